/* SPDX-License-Identifier: Apache-2.0 */
/* The edge of the module patina_oiio.so, which reads and writes every format but EXR. It is loaded only when
   such a file is met, as OpenImageIO costs 200 ms to start. Plain C: no exception, allocation or C++ type
   crosses it. */
#pragma once

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define PATINA_IMAGE_MODULE_VERSION 1
#define PATINA_IMAGE_MODULE_SYMBOL "patinaImageModule1"

enum PatinaPixelType { PATINA_PIXEL_U8 = 0, PATINA_PIXEL_U16 = 1, PATINA_PIXEL_F32 = 2 };

/* An image to be written. All memory is the caller's. */
typedef struct PatinaImageToWrite {
  uint32_t structSize;
  int32_t width, height, channels;
  int32_t x, y;                  /* place of the first pixel in the full raster */
  int32_t fullWidth, fullHeight; /* the full raster */
  int32_t pixelType;             /* of `pixels` and of the file: PatinaPixelType */
  const void* pixels;            /* rows from the top, channels interleaved, unpadded */
  const char* const* channelNames;
  int32_t alphaChannel, depthChannel; /* -1 = none */
  int32_t unassociatedAlpha;          /* 1 = colour is not multiplied by alpha */
  int32_t srgb;                       /* 1 = values carry the sRGB curve */
  int32_t attributeCount;
  const char* const* attributeNames; /* text attributes */
  const char* const* attributeValues;
  const float* worldToCamera; /* 16 floats, row vectors, or NULL */
  const float* worldToScreen;
} PatinaImageToWrite;

/* What a file holds, known before its pixels are read. */
typedef struct PatinaImageInfo {
  uint32_t structSize;
  int32_t width, height, channels;
  int32_t srgb; /* 1 = integers that carry the sRGB curve; 0 = linear */
} PatinaImageInfo;

typedef void (*PatinaByteSink)(void* context, const void* bytes, size_t size);

typedef struct PatinaImageModule {
  uint32_t version; /* PATINA_IMAGE_MODULE_VERSION */
  /* Encodes an image in the named OpenImageIO format and hands the whole file to `sink` once; the host writes
     it, as the format libraries do not all notice a full disk. Returns 1, or 0 with a text in `error`. [any
     thread] */
  int (*encode)(const char* format, const PatinaImageToWrite* image, PatinaByteSink sink, void* context,
                char* error, size_t errorSize);
  /* Opens a file; NULL with a text in `error`. The handle belongs to one thread at a time. [any thread] */
  void* (*open)(const char* path, PatinaImageInfo* info, char* error, size_t errorSize);
  /* Reads all pixels as floats (integers to 0..1, curves left as they are): width*height*channels, rows from
     the top. Returns 1, or 0 with a text in `error`. */
  int (*read)(void* handle, float* pixels, char* error, size_t errorSize);
  void (*close)(void* handle);
  /* Applies an OpenColorIO view to `count` RGB triples of linear Rec.709, in place. Returns 1, or 0 with a
     text in `error` that lists the known views. [any thread] */
  int (*applyView)(const char* view, float* rgb, size_t count, char* error, size_t errorSize);
} PatinaImageModule;

#ifdef __cplusplus
}
#endif
