/* SPDX-License-Identifier: Apache-2.0 */
/* A shader with a lobe of its own, diffuse reflection, in plain C; what is defined on the command line is
 * what it does wrong. */
#include <math.h>
#include <patina/shader.h>
#include <stdlib.h>

#define PI 3.14159265f
static const float kShare = 0.5f;
static const PatinaParameter kParameters[] = {{sizeof(PatinaParameter), PATINA_FLOAT, PATINA_VARYING, 0,
                                               "share", "of light reflected", "", &kShare, NULL, NULL, 0, 1}};

static float at(PatinaPlane plane, uint32_t i) { return plane.data[(size_t)i * plane.stride]; }
static float cosine(const PatinaLobeIn* in, PatinaPlane3 w, uint32_t i) {
  return at(w.x, i) * at(in->N.x, i) + at(w.y, i) * at(in->N.y, i) + at(w.z, i) * at(in->N.z, i);
}

static PatinaStatus evaluate(void* instance, const PatinaLobeIn* in, PatinaLobeOut* out) {
  (void)instance;
  for (uint32_t i = 0; i < in->count; ++i) {
    const float z = cosine(in, in->wi, i);
    float f = at(in->data[0], i) * z / PI;
    out->pdf[i] = z / PI;
#if defined(WRONG_LOBE_PDF)
    out->pdf[i] = 1.2f * z / PI;
#elif defined(LOBE_MAKES_ENERGY)
    f = 1.5f * z / PI;
#elif defined(ONE_WAY_LOBE)
    f *= cosine(in, in->wo, i);
#elif defined(NAN_LOBE)
    if (z < 1e-5f) f /= 0 * z;
#elif defined(NEGATIVE_LOBE)
    f = -f;
#endif
    out->f.x[i] = out->f.y[i] = out->f.z[i] = f;
  }
  return PATINA_OK;
}

static PatinaStatus sample(void* instance, const PatinaLobeIn* in, PatinaLobeOut* out) {
  (void)instance;
  for (uint32_t i = 0; i < in->count; ++i) {
    /* A point on the unit sphere around the tip of the normal, seen from the foot of it. */
    const float z = 1 - 2 * at(in->random_x, i), radius = sqrtf(fmaxf(0, 1 - z * z)),
                phi = 2 * PI * at(in->random_y, i);
    float x[3] = {radius * cosf(phi) + at(in->N.x, i), radius * sinf(phi) + at(in->N.y, i),
                  z + at(in->N.z, i)};
    float length = sqrtf(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
#if defined(WRONG_LOBE_SAMPLES) /* nearer to the normal */
    for (int c = 0; c < 3; ++c) x[c] += c == 0 ? at(in->N.x, i) : c == 1 ? at(in->N.y, i) : at(in->N.z, i);
    length = sqrtf(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
#elif defined(LONG_LOBE_SAMPLES)
    length *= 0.9f;
#endif
    if (length < 1e-6f) continue;
    out->wi.x[i] = x[0] / length, out->wi.y[i] = x[1] / length, out->wi.z[i] = x[2] / length;
  }
  return PATINA_OK;
}

#if defined(NAMELESS_LOBE)
#define NAME ""
#else
#define NAME "cosine"
#endif
static const PatinaCustomLobe kLobe = {
    sizeof(PatinaCustomLobe), PATINA_LOBE_REFLECTS, NAME, "diffuse reflection", 1, 0, evaluate, sample};

static PatinaStatus prepare(const PatinaPrepare* in, void** instance, PatinaTraits* traits) {
  const PatinaLobeRegistry* lobes =
      (const PatinaLobeRegistry*)in->host->extension(in->host->host, PATINA_EXTENSION_CUSTOM_LOBES);
  uint32_t* type = (uint32_t*)calloc(1, sizeof(uint32_t));
  *instance = type;
  if (!lobes || !type) return PATINA_ERROR_RESOURCE;
  *type = lobes->add(in->host->host, &kLobe);
#if defined(UNKNOWN_LOBE)
  ++*type;
#endif
  traits->active = 1u << PATINA_ENTRY_VIEW;
  traits->flags = PATINA_TRAIT_OPAQUE | PATINA_TRAIT_BLACK;
  return PATINA_OK;
}
static void release(void* instance) { free(instance); }

static PatinaStatus displacement(void* instance, const PatinaPoints* in, PatinaDisplacementOut* out) {
  return (void)instance, (void)in, (void)out, PATINA_OK;
}
static PatinaStatus light(void* instance, const PatinaLightIn* in, PatinaLightOut* out) {
  return (void)instance, (void)in, (void)out, PATINA_OK;
}
static PatinaStatus radiosity(void* instance, const PatinaPoints* in, PatinaRadiosityOut* out) {
  return (void)instance, (void)in, (void)out, PATINA_OK;
}
static PatinaStatus view(void* instance, const PatinaPoints* in, PatinaViewOut* out) {
  PatinaLobe* lobe = out->lobes;
  lobe->type = *(const uint32_t*)instance;
  out->lobe_count = 1;
  for (uint32_t i = 0; i < in->count; ++i) {
    lobe->weight.x[i] = lobe->weight.y[i] = lobe->weight.z[i] = 1;
    lobe->alpha[i] = 1;
    if (lobe->data_count > 0) lobe->data[0][i] = in->values->floats[i * in->values->stride];
  }
  return PATINA_OK;
}

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
