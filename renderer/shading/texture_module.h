/* SPDX-License-Identifier: Apache-2.0 */
/* The edge of the module patina_texture.so, which looks textures up through OpenImageIO. It is loaded with
 * the first texture, as OpenImageIO costs 200 ms to start. Plain C: no exception, allocation or C++ type
 * crosses it. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#include "patina/shader.h"

#ifdef __cplusplus
extern "C" {
#endif

#define PATINA_TEXTURE_MODULE_VERSION 1u
#define PATINA_TEXTURE_MODULE_SYMBOL "patina_texture_module_v1"

typedef struct PatinaTextureLookup {
  PatinaPlane s, t;             /* t = 0: the top row */
  PatinaPlane width_s, width_t; /* of the filter, in s, t units */
  int32_t wrap_t;               /* 1: t wraps around as s always does; 0: it is clamped */
} PatinaTextureLookup;

typedef struct PatinaTextureModule {
  uint32_t version;
  /* A cache of at most `budget` bytes; NULL = not to be had. [any] */
  void* (*create)(size_t budget);
  void (*destroy)(void* system);
  /* A texture by path: NULL with a text in `error`. It lives as long as the system. [any] */
  void* (*open)(void* system, const char* path, uint32_t* width, uint32_t* height, uint32_t* channels,
                char* error, size_t error_size);
  /* `alpha` may be NULL. 0 with a text in `error`: lanes that could not be read are 1. [any] */
  int (*lookup)(void* system, void* texture, uint32_t channels, uint32_t count, const PatinaTextureLookup* in,
                PatinaOut3 color, float* alpha, char* error, size_t error_size);
  uint64_t (*bytes)(void* system); /* held by the cache now [any] */
} PatinaTextureModule;

#ifdef __cplusplus
}
#endif
