/* SPDX-License-Identifier: Apache-2.0 */
/* A small shader in plain C. What is defined on the command line is what is wrong with it; nothing = it is
 * good. */
#include <math.h>
#include <patina/shader.h>

static const float kDefaults[] = {1, 0.5f, 0.25f, 0.125f};

#if defined(UNNAMED_PARAMETER)
#define FIRST_NAME NULL
#else
#define FIRST_NAME "gain"
#endif
#if defined(PARAMETER_TWICE)
#define SECOND_NAME "gain"
#else
#define SECOND_NAME "tint"
#endif
#if defined(UNKNOWN_TYPE)
#define SECOND_TYPE 77
#else
#define SECOND_TYPE PATINA_COLOR
#endif
#if defined(DEFAULT_MISSING)
#define SECOND_DEFAULT NULL
#else
#define SECOND_DEFAULT (kDefaults + 1)
#endif

static const PatinaParameter kParameters[] = {{sizeof(PatinaParameter), PATINA_FLOAT, PATINA_UNIFORM, 0,
                                               FIRST_NAME, "scale", "", kDefaults, NULL, NULL, 0, 1},
                                              {sizeof(PatinaParameter), SECOND_TYPE, PATINA_VARYING, 0,
                                               SECOND_NAME, "colour", "", SECOND_DEFAULT, NULL, NULL, 1, 0}};

#ifndef LACKS_PREPARE
static PatinaStatus prepare(const PatinaPrepare* in, void** instance, PatinaTraits* traits) {
  (void)in, (void)instance;
  traits->active = 1u << PATINA_ENTRY_RADIOSITY;
  traits->reads[PATINA_ENTRY_RADIOSITY] = PATINA_CHANNEL_CS;
#if defined(READS_I_IN_RADIOSITY)
  traits->reads[PATINA_ENTRY_RADIOSITY] |= PATINA_CHANNEL_I;
#elif defined(UNKNOWN_LIGHT_KIND)
  traits->active |= 1u << PATINA_ENTRY_LIGHT;
  traits->light_kind = 9;
#elif defined(INFINITE_BOUND)
  traits->displacement_bound = INFINITY;
#elif defined(PREPARE_FAILS)
  return PATINA_ERROR_RESOURCE;
#endif
  return PATINA_OK;
}
#else
#define prepare NULL
#endif

#ifndef LACKS_DISPLACEMENT
static PatinaStatus displacement(void* instance, const PatinaPoints* in, PatinaDisplacementOut* out) {
  return (void)instance, (void)in, (void)out, PATINA_OK;
}
#else
#define displacement NULL
#endif

#ifndef LACKS_LIGHT
static PatinaStatus light(void* instance, const PatinaLightIn* in, PatinaLightOut* out) {
  return (void)instance, (void)in, (void)out, PATINA_OK;
}
#else
#define light NULL
#endif

#ifndef LACKS_RADIOSITY
#if defined(UNDEFINED_FUNCTION)
float patina_no_such_function(float x);
#elif defined(CALLS_GONE)
int patina_gone(void);
#endif
static PatinaStatus radiosity(void* instance, const PatinaPoints* in, PatinaRadiosityOut* out) {
  (void)instance;
  for (uint32_t i = 0; i < in->count; ++i) out->reflectance.x[i] = in->Cs.x.data[i * in->Cs.x.stride];
#if defined(UNDEFINED_FUNCTION)
  out->reflectance.x[0] = patina_no_such_function(out->reflectance.x[0]);
#elif defined(CALLS_GONE)
  out->reflectance.x[0] = (float)patina_gone();
#endif
  return PATINA_OK;
}
#else
#define radiosity NULL
#endif

#ifndef LACKS_VIEW
static PatinaStatus view(void* instance, const PatinaPoints* in, PatinaViewOut* out) {
  return (void)instance, (void)in, (void)out, PATINA_OK;
}
#else
#define view NULL
#endif

#if defined(SMALL_STRUCT)
#define SHADER_SIZE 16
#else
#define SHADER_SIZE sizeof(PatinaShader)
#endif
#if defined(OTHER_NAME)
#define SHADER_NAME "another"
#else
#define SHADER_NAME PLUGIN_NAME
#endif

static const PatinaShader kShader = {
    SHADER_SIZE, PATINA_ABI_MINOR, SHADER_NAME, "for tests", kParameters, 2, sizeof(PatinaParameter), prepare,
    NULL,        displacement,     light,       radiosity,   view};

#if defined(VERSION_2)
extern PATINA_EXPORT const PatinaShader* const patina_shaders_v2[];
const PatinaShader* const patina_shaders_v2[] = {&kShader, NULL};
#elif defined(SYMBOL_MISSING)
extern PATINA_EXPORT const PatinaShader* const some_other_symbol[];
const PatinaShader* const some_other_symbol[] = {&kShader, NULL};
#elif defined(EMPTY_TABLE)
const PatinaShader* const patina_shaders_v1[] = {NULL};
extern PATINA_EXPORT const PatinaShader* const some_other_symbol;
const PatinaShader* const some_other_symbol = &kShader;
#elif defined(ENDLESS_TABLE)
const PatinaShader* const patina_shaders_v1[] = {&kShader};
#else
const PatinaShader* const patina_shaders_v1[] = {&kShader, NULL};
#endif

#if defined(CHANGES_ROUNDING) && defined(__SSE__)
#include <xmmintrin.h>
/* What linking with -ffast-math does. */
__attribute__((constructor)) static void flushDenormals(void) { _mm_setcsr(_mm_getcsr() | 0x8040); }
#endif
