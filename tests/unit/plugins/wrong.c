/* SPDX-License-Identifier: Apache-2.0 */
/* Shaders that load well and misbehave when they are called: what is defined on the command line is what they
 * do wrong; nothing = they do all well. */
#include <math.h>
#include <patina/shader.h>
#include <stdlib.h>
#if defined(WAITS)
#include <unistd.h>
#endif

static const float kKd = 0.5f;
#if defined(DEFAULT_OUT_OF_RANGE)
#define KD_MAXIMUM 0.25
#else
#define KD_MAXIMUM 0.6
#endif
static const PatinaParameter kParameters[] = {{sizeof(PatinaParameter), PATINA_FLOAT, PATINA_VARYING, 0, "Kd",
                                               "share of light reflected", "", &kKd, NULL, NULL, 0,
                                               KD_MAXIMUM}};

#define INSTANCE_FLOATS 1024
#if defined(WRONG_PDF) || defined(WRONG_SAMPLES) || defined(RIGHT_PDF) || defined(NO_FALL_OFF) || \
    defined(LONG_DIRECTIONS) || defined(NEGATIVE_LIGHT) || defined(EVALUATES_OTHERWISE) ||        \
    defined(LIGHT_READS_NEIGHBOURS) || defined(RANDOM_DELTA)
#define IS_LIGHT 1
#else
#define IS_LIGHT 0
#endif

#if defined(RIGHT_RAYS) || defined(UNDECLARED_RAYS) || defined(TOO_MANY_RAYS) || defined(NAN_RAYS) || \
    defined(RAYS_OF_DISPLACEMENT)
#define HAS_RAYS 1
#else
#define HAS_RAYS 0
#endif

#if defined(LATE_TEXTURE)
static const PatinaHost* gHost;
#endif

#if HAS_RAYS
static const PatinaRays* raysOf(const PatinaHost* host) {
  return (const PatinaRays*)host->extension(host->host, PATINA_EXTENSION_RAYS);
}
#endif

#if defined(BRIGHT_AIR)
static PatinaStatus air(void* instance, const PatinaAtmosphereIn* in, PatinaAtmosphereOut* out) {
  (void)instance;
  for (uint32_t i = 0; i < in->count; ++i) out->transmittance.y[i] = 1.5f;
  return PATINA_OK;
}
#endif

static PatinaStatus prepare(const PatinaPrepare* in, void** instance, PatinaTraits* traits) {
  (void)in;
#if defined(LATE_TEXTURE)
  gHost = in->host;
#endif
#if defined(BRIGHT_AIR)
  const PatinaAtmospheres* airs =
      (const PatinaAtmospheres*)in->host->extension(in->host->host, PATINA_EXTENSION_ATMOSPHERE);
  if (airs) airs->set(in->host->host, air);
#endif
#if HAS_RAYS
  const PatinaRays* rays = raysOf(in->host);
  if (!rays) return PATINA_ERROR_RESOURCE;
#if defined(RAYS_OF_DISPLACEMENT)
  rays->declare(in->host->host, PATINA_ENTRY_DISPLACEMENT, 2);
#elif !defined(UNDECLARED_RAYS)
  rays->declare(in->host->host, PATINA_ENTRY_RADIOSITY, 2);
#endif
#endif
  traits->active = 1u << PATINA_ENTRY_RADIOSITY | 1u << PATINA_ENTRY_DISPLACEMENT;
  traits->reads[PATINA_ENTRY_RADIOSITY] = PATINA_CHANNEL_CS | PATINA_CHANNEL_OS | PATINA_CHANNEL_FOOTPRINT;
  traits->reads[PATINA_ENTRY_DISPLACEMENT] = PATINA_CHANNEL_P | PATINA_CHANNEL_N;
  traits->flags = PATINA_TRAIT_OPACITY_IS_OS | PATINA_TRAIT_TRANSMITS;
  traits->displacement_bound = 0.1f;
#if defined(FALSE_NO_OP)
  traits->active &= ~(1u << PATINA_ENTRY_RADIOSITY);
#elif defined(FALSE_BLACK)
  traits->flags |= PATINA_TRAIT_BLACK;
#elif defined(RANDOM_DELTA)
  traits->light_kind = PATINA_LIGHT_DELTA;
#elif defined(NO_FALL_OFF)
  traits->light_kind = PATINA_LIGHT_DELTA;
  traits->flags |= PATINA_TRAIT_FROM_POINT;
#elif IS_LIGHT
  traits->light_kind = PATINA_LIGHT_INFINITE;
#endif
  if (IS_LIGHT) traits->active = 1u << PATINA_ENTRY_LIGHT;
#if defined(BRIGHT_LOBE)
  traits->active |= 1u << PATINA_ENTRY_VIEW;
#endif
  *instance = calloc(INSTANCE_FLOATS, sizeof(float));
#if HAS_RAYS
  if (*instance) *(const PatinaHost**)*instance = in->host;
#endif
  return *instance ? PATINA_OK : PATINA_ERROR_RESOURCE;
}

static void release(void* instance) {
#if !defined(LEAKS)
  free(instance);
#else
  (void)instance;
#endif
}

static float at(PatinaPlane plane, uint32_t i) {
#if defined(IGNORES_STRIDE)
  return plane.data[i];
#else
  return plane.data[(size_t)i * plane.stride];
#endif
}

static PatinaStatus displacement(void* instance, const PatinaPoints* in, PatinaDisplacementOut* out) {
#if defined(EXCEEDS_BOUND)
  const float height = 0.2f;
#else
  const float height = 0.1f;
#endif
  (void)instance;
  if (IS_LIGHT) return PATINA_OK;
  for (uint32_t i = 0; i < in->count; ++i) {
    out->P.x[i] = at(in->P.x, i) + height * at(in->N.x, i);
    out->P.y[i] = at(in->P.y, i) + height * at(in->N.y, i);
    out->P.z[i] = at(in->P.z, i) + height * at(in->N.z, i);
#if defined(LONG_NORMALS)
    out->N.x[i] = 2 * at(in->N.x, i), out->N.y[i] = 2 * at(in->N.y, i), out->N.z[i] = 2 * at(in->N.z, i);
#endif
  }
#if defined(LONG_NORMALS)
  out->writes_normal = 1;
#endif
  return PATINA_OK;
}

/* The one colour channel that is wrong is x. */
static float reflected(const PatinaPoints* in, uint32_t i, float* instance) {
  const float color = at(in->Cs.x, i);
  (void)instance, (void)color;
#if defined(READS_I)
  return in->I.x.data ? color * fabsf(at(in->I.x, i)) : color;
#elif defined(NEEDS_I)
  return color * fabsf(in->I.x.data[i]);
#elif defined(READS_NEIGHBOURS)
  return at(in->Cs.x, i + 1 < in->count ? i + 1 : 0);
#elif defined(GIVES_NAN)
  return color * at(in->footprint, i) / at(in->footprint, i);
#elif defined(REMEMBERS)
  const float last = instance[0];
  instance[0] = color;
  return last;
#elif defined(HANGS)
  while (at(in->footprint, i) > 1e12f && *(volatile float*)instance == 0) continue;
  return color;
#elif defined(WAITS)
  if (at(in->footprint, i) > 1e12f) sleep(1000);
  return color;
#elif defined(EXITS)
  if (at(in->footprint, i) > 1e12f) exit(3);
  return color;
#else
  return color;
#endif
}

#if HAS_RAYS
#if defined(TOO_MANY_RAYS)
#define RAYS 3
#else
#define RAYS 2
#endif
/* By how much each of two lanes' surroundings are open, upwards and downwards. */
static void lookAround(void* instance, const PatinaPoints* in, uint32_t first, float* open) {
  const PatinaHost* host = *(const PatinaHost**)instance;
  float direction[2 * RAYS], distance[2 * RAYS], occluded[2 * RAYS];
  uint32_t lane[2 * RAYS];
  const float zero = 0, maximum = 5;
  const uint32_t points = in->count - first < 2 ? 1 : 2;
  PatinaRayIn rays = {sizeof(PatinaRayIn),
                      points * RAYS,
                      lane,
                      {{NULL, 0, 0}, {NULL, 0, 0}, {NULL, 0, 0}},
                      {{&zero, 0, 0}, {&zero, 0, 0}, {direction, 1, 0}},
                      {&maximum, 0, 0}};
  PatinaRayOut met = {sizeof(PatinaRayOut), 0, distance, occluded};
  for (uint32_t k = 0; k < rays.count; ++k) lane[k] = first + k / RAYS, direction[k] = k % 2 ? -1.0f : 1.0f;
#if defined(NAN_RAYS)
  direction[0] = sqrtf(-1 - maximum);
#endif
  open[0] = open[1] = 1;
  if (raysOf(host)->trace(host->host, &rays, &met) != PATINA_OK) return;
  for (uint32_t k = 0; k < rays.count; ++k)
    if (occluded[k] != 0) open[k / RAYS] *= distance[k] / maximum;
}
#endif

static PatinaStatus radiosity(void* instance, const PatinaPoints* in, PatinaRadiosityOut* out) {
  const PatinaValue* kd = in->values;
#if defined(LATE_TEXTURE)
  gHost->open_texture(gHost->host, "late.tx");
#endif
  if (IS_LIGHT) return PATINA_OK;
#if defined(RACES)
  volatile float* scratch = instance;
  for (uint32_t i = 0; i < in->count; ++i) scratch[i] = at(in->Cs.x, i);
#endif
#if HAS_RAYS
  float open[2] = {1, 1};
#endif
  for (uint32_t i = 0; i < in->count; ++i) {
    const float weight = kd->floats[i * kd->stride], opacity = at(in->Os.x, i);
    out->reflectance.x[i] = weight * opacity * reflected(in, i, instance);
    out->reflectance.y[i] = weight * at(in->Os.y, i) * at(in->Cs.y, i);
    out->reflectance.z[i] = weight * at(in->Os.z, i) * at(in->Cs.z, i);
#if HAS_RAYS
    if (i % 2 == 0) lookAround(instance, in, i, open);
    out->reflectance.z[i] *= open[i % 2];
#endif
    out->opacity.x[i] = opacity;
    out->opacity.y[i] = at(in->Os.y, i);
    out->opacity.z[i] = at(in->Os.z, i);
#if defined(MAKES_ENERGY)
    out->transmittance.x[i] = 0.7f * opacity;
#elif defined(FALSE_NO_OP)
    out->emission.x[i] = 1;
#elif defined(RACES)
    out->reflectance.x[i] = weight * opacity * scratch[i];
#endif
  }
#if defined(OUT_OF_BOUNDS)
  out->reflectance.x[in->padded] = 1;
#elif defined(WRITES_INPUT)
  *(float*)in->Cs.y.data = 0.125f;
#endif
  return PATINA_OK;
}

static PatinaStatus view(void* instance, const PatinaPoints* in, PatinaViewOut* out) {
#if defined(BRIGHT_LOBE)
  out->lobe_count = 1;
  out->lobes[0].type = PATINA_LOBE_GGX;
  for (uint32_t i = 0; i < in->count; ++i) out->lobes[0].weight.y[i] = 2, out->lobes[0].alpha[i] = 0.5f;
#endif
  return (void)instance, (void)in, (void)out, PATINA_OK;
}

#if IS_LIGHT && !defined(NO_FALL_OFF)
#define PI 3.14159265f
#if defined(WRONG_PDF)
#define PDF (1 / (2 * PI))
#else
#define PDF (1 / (4 * PI))
#endif

/* A sky of one colour. */
static PatinaStatus light(void* instance, const PatinaLightIn* in, PatinaLightOut* out) {
  (void)instance;
  for (uint32_t i = 0; i < in->count; ++i) {
    if (in->task == PATINA_LIGHT_SAMPLE) {
#if defined(WRONG_SAMPLES)
      const float z = 1 - at(in->random_x, i); /* only above */
#else
      const float z = 1 - 2 * at(in->random_x, i);
#endif
      const float radius = sqrtf(fmaxf(0, 1 - z * z)), phi = 2 * PI * at(in->random_y, i);
      out->direction.x[i] = radius * cosf(phi), out->direction.y[i] = radius * sinf(phi);
      out->direction.z[i] = z;
#if defined(LONG_DIRECTIONS)
      out->direction.z[i] += 0.1f;
#endif
      out->distance[i] = PATINA_INFINITE_DISTANCE;
    }
    out->radiance.x[i] = out->radiance.y[i] = out->radiance.z[i] = 1;
    out->pdf[i] = PDF;
#if defined(NEGATIVE_LIGHT)
    out->radiance.z[i] = -0.5f;
#elif defined(EVALUATES_OTHERWISE)
    if (in->task == PATINA_LIGHT_EVALUATE) out->radiance.y[i] = 0.9f;
#elif defined(LIGHT_READS_NEIGHBOURS)
    out->radiance.x[i] = i + 1 < in->count ? 0.5f : 1;
#endif
  }
  return PATINA_OK;
}
#elif defined(NO_FALL_OFF)
/* Shines from the origin, and as much everywhere. */
static PatinaStatus light(void* instance, const PatinaLightIn* in, PatinaLightOut* out) {
  (void)instance;
  for (uint32_t i = 0; i < in->count; ++i) {
    const float x = at(in->P.x, i), y = at(in->P.y, i), z = at(in->P.z, i);
    const float distance = sqrtf(x * x + y * y + z * z);
    out->direction.x[i] = -x / distance, out->direction.y[i] = -y / distance,
    out->direction.z[i] = -z / distance;
    out->distance[i] = distance;
    out->radiance.x[i] = out->radiance.y[i] = out->radiance.z[i] = 1;
  }
  return PATINA_OK;
}
#else
static PatinaStatus light(void* instance, const PatinaLightIn* in, PatinaLightOut* out) {
  return (void)instance, (void)in, (void)out, PATINA_OK;
}
#endif

static const PatinaShader kShader = {sizeof(PatinaShader),
                                     PATINA_ABI_MINOR,
                                     PLUGIN_NAME,
                                     "for tests",
                                     kParameters,
                                     1,
                                     sizeof(PatinaParameter),
                                     prepare,
                                     release,
                                     displacement,
                                     light,
                                     radiosity,
                                     view};

const PatinaShader* const patina_shaders_v1[] = {&kShader, NULL};
