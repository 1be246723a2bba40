/* SPDX-License-Identifier: Apache-2.0 */
/* A shader that ends the process where an entry point is called that its traits, the bits of the parameter
 * "active", do not name in earnest: but for radiosity none does anything. */
#include <patina/shader.h>
#include <stddef.h>
#include <stdlib.h>

static const int32_t kActive[] = {1 << PATINA_ENTRY_RADIOSITY};
static const PatinaParameter kParameters[] = {{sizeof(PatinaParameter), PATINA_INT, PATINA_UNIFORM, 0,
                                               "active", "traits.active", "", NULL, kActive, NULL, 0, 15}};

static PatinaStatus prepare(const PatinaPrepare* in, void** instance, PatinaTraits* traits) {
  (void)instance;
  traits->active = (uint32_t)in->values->ints[0];
  traits->light_kind = PATINA_LIGHT_DELTA;
  traits->flags = PATINA_TRAIT_OPAQUE | PATINA_TRAIT_EMITS;
  return PATINA_OK;
}
static PatinaStatus displacement(void* instance, const PatinaPoints* in, PatinaDisplacementOut* out) {
  (void)instance, (void)in, (void)out;
  abort();
}
static PatinaStatus light(void* instance, const PatinaLightIn* in, PatinaLightOut* out) {
  (void)instance, (void)in, (void)out;
  abort();
}
static PatinaStatus view(void* instance, const PatinaPoints* in, PatinaViewOut* out) {
  (void)instance, (void)in, (void)out;
  abort();
}
static PatinaStatus radiosity(void* instance, const PatinaPoints* in, PatinaRadiosityOut* out) {
  (void)instance;
  for (uint32_t i = 0; i < in->count; ++i) {
    out->emission.x[i] = out->emission.y[i] = out->emission.z[i] = 0.5f;
    out->reflectance.x[i] = out->reflectance.y[i] = out->reflectance.z[i] = 0.5f;
  }
  return PATINA_OK;
}

static const PatinaShader kShader = {sizeof(PatinaShader),
                                     PATINA_ABI_MINOR,
                                     "inactive",
                                     "for tests",
                                     kParameters,
                                     1,
                                     sizeof(PatinaParameter),
                                     prepare,
                                     NULL,
                                     displacement,
                                     light,
                                     radiosity,
                                     view};
const PatinaShader* const patina_shaders_v1[] = {&kShader, NULL};
