/* SPDX-License-Identifier: Apache-2.0 */
/* An extension of the host (see PatinaHost.extension): files that are no textures, found where a scene has them. C11 and
 * C++17. */
#ifndef PATINA_FILES_H
#define PATINA_FILES_H

#include "shader.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PATINA_EXTENSION_FILES "patina.files/1"

typedef struct PatinaFiles {
    uint32_t struct_size;
    uint32_t reserved;
    /* The path of `name`, which a scene gives as a shader's argument: beside the file of the request that binds the
       shader, else as it is. NULL: there is no such file. Only regular files are found. During `prepare` only; the
       string is the host's and lives until the next call of that thread. [main] */
    const char *(*find)(void *host, const char *name);
} PatinaFiles;

#ifdef __cplusplus
}
#endif
#endif
