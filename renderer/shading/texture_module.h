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

#define PATINA_TEXTURE_MODULE_VERSION 2u
#define PATINA_TEXTURE_MODULE_SYMBOL "patina_texture_module_v2"

typedef enum PatinaTextureWrap {
  PATINA_WRAP_CLAMP = 0,
  PATINA_WRAP_PERIODIC = 1,
  PATINA_WRAP_FILE = 2 /* as the file says, by its MakeTexture; periodic where it says nothing */
} PatinaTextureWrap;

typedef struct PatinaTextureLookup {
  PatinaPlane s, t;             /* t = 0: the top row */
  PatinaPlane width_s, width_t; /* of the filter, in s, t units */
  int32_t wrap_s, wrap_t;       /* PatinaTextureWrap */
} PatinaTextureLookup;

typedef struct PatinaTextureInfo {
  void* handle; /* NULL: it could not be opened */
  uint32_t width, height, channels;
  int32_t wraps; /* 1: the file says how it wraps */
} PatinaTextureInfo;

/* One file of a pattern. [the caller's thread] */
typedef void (*PatinaTileSink)(void* context, uint32_t column, uint32_t row, const char* path);

typedef enum PatinaMakeKind {
  PATINA_MAKE_TEXTURE = 0,
  PATINA_MAKE_LATLONG = 1,
  PATINA_MAKE_CUBE_FACES = 2, /* becomes a latitude-longitude picture */
  PATINA_MAKE_SHADOW = 3
} PatinaMakeKind;

typedef struct PatinaTextureToMake {
  uint32_t kind;               /* PatinaMakeKind */
  uint32_t picture_count;      /* 1; of CUBE_FACES 6: px nx py ny pz nz */
  const char* const* pictures; /* paths */
  const char* output;          /* path, of any suffix */
  const char* format;          /* OpenImageIO's name: "tiff", "openexr" */
  const char* wrap_modes;      /* OpenImageIO's: "black,periodic" */
  const char* filter;          /* OpenImageIO's; "" = its default */
  const char*
      color_space; /* "raw" and "linear": values as they are; "srgb"; "": as when a texture is opened */
  const char* ocio_config; /* path, "" = none */
  float fov;               /* CUBE_FACES: degrees */
} PatinaTextureToMake;

typedef struct PatinaTextureModule {
  uint32_t version;
  /* A cache of at most `budget` bytes; NULL = not to be had. `ocio_config`: path of an OpenColorIO
   * configuration, "" = none; one that cannot be used leaves a text in `error`, and is none. [any] */
  void* (*create)(size_t budget, const char* ocio_config, char* error, size_t error_size);
  void (*destroy)(void* system);
  /* A texture by path. `data`: its values are taken as they are, else they become linear Rec.709 (see
   * texture_color_module.h). 0 with a text in `error`. It lives as long as the system. [any] */
  int (*open)(void* system, const char* path, int32_t data, PatinaTextureInfo* info, char* error,
              size_t error_size);
  /* Calls `sink` for every file of a pattern of tiles, as <UDIM>; 0 with a text in `error`: there would be
   * too many. [any] */
  int (*tiles)(void* system, const char* pattern, PatinaTileSink sink, void* context, char* error,
               size_t error_size);
  /* `alpha` may be NULL. How many lanes could not be read, with a text in `error`: they are 1. [any] */
  uint32_t (*lookup)(void* system, const PatinaTextureInfo* texture, uint32_t count,
                     const PatinaTextureLookup* in, PatinaOut3 color, float* alpha, char* error,
                     size_t error_size);
  uint64_t (*bytes)(void* system); /* held by the cache now [any] */
  /* Whether the file is a picture. [any] */
  int (*is_picture)(const char* path);
  /* Writes a tiled texture with all its levels, linear and of no less than 16 bits, to `output`, and there
   * alone. 0 with a text in `error`: it may be there in parts. [any] */
  int (*make)(const PatinaTextureToMake* what, char* error, size_t error_size);
} PatinaTextureModule;

#ifdef __cplusplus
}
#endif
