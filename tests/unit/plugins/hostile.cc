// SPDX-License-Identifier: Apache-2.0
// A shader against the interface, written without patina/sdk.h: parameter "where" names the entry point that
// does what "what" says; all others do well.
//   throws, throws int     C++ exceptions
//   fails                  a status
//   hangs                  never returns
//   writes behind, writes before   outside of the planes that it was given
//   nan, inf, negative, huge       as values
#include <patina/shader.h>
#include <time.h>

#include <cmath>
#include <cstring>
#include <stdexcept>

namespace {

const char* const kNothing = "";
const PatinaParameter kParameters[] = {{sizeof(PatinaParameter), PATINA_STRING, PATINA_UNIFORM, 0, "where",
                                        "entry point", "", nullptr, nullptr, &kNothing, 1, 0},
                                       {sizeof(PatinaParameter), PATINA_STRING, PATINA_UNIFORM, 0, "what",
                                        "what it does", "", nullptr, nullptr, &kNothing, 1, 0}};

struct Instance {
  const char *where, *what;
};

const char* valueOf(const PatinaPrepare* in, unsigned k) {
  return reinterpret_cast<const PatinaValue*>(reinterpret_cast<const char*>(in->values) +
                                              size_t{k} * in->value_stride)
      ->strings[0];
}

// What may be done before anything is written.
PatinaStatus misbehave(const Instance& instance, const char* where) {
  if (std::strcmp(instance.where, where) != 0) return PATINA_OK;
  const auto is = [&](const char* what) { return std::strcmp(instance.what, what) == 0; };
  if (is("throws")) throw std::runtime_error("out of spite");
  if (is("throws int")) throw 7;
  if (is("fails")) return PATINA_ERROR_PARAMETER;
  while (is("hangs")) {
    const timespec aWhile{0, 10'000'000};
    nanosleep(&aWhile, nullptr);
  }
  return PATINA_OK;
}

// What may be written to a plane, which is filled.
void spoil(const Instance& instance, const char* where, float* plane, uint32_t count, uint32_t padded) {
  if (std::strcmp(instance.where, where) != 0) return;
  const auto is = [&](const char* what) { return std::strcmp(instance.what, what) == 0; };
  if (is("writes behind")) plane[padded] = 1;
  if (is("writes before")) plane[-1] = 1;
  for (uint32_t i = 0; i < count; ++i) {
    if (is("nan")) plane[i] = NAN;
    if (is("inf")) plane[i] = INFINITY;
    if (is("negative")) plane[i] = -1e6f;
    if (is("huge")) plane[i] = 1e30f;
  }
}

PatinaStatus prepare(const PatinaPrepare* in, void** instance, PatinaTraits* traits) {
  Instance* const made = new Instance{valueOf(in, 0), valueOf(in, 1)};
  *instance = made;
  const bool isLight = std::strcmp(made->where, "light") == 0;
  traits->active =
      isLight ? 1u << PATINA_ENTRY_LIGHT
              : 1u << PATINA_ENTRY_RADIOSITY | 1u << PATINA_ENTRY_VIEW | 1u << PATINA_ENTRY_DISPLACEMENT;
  traits->light_kind = isLight ? PATINA_LIGHT_DELTA : PATINA_LIGHT_NONE;
  traits->flags = PATINA_TRAIT_OPAQUE | PATINA_TRAIT_EMITS;
  traits->reads[PATINA_ENTRY_DISPLACEMENT] = PATINA_CHANNEL_P;
  return misbehave(*made, "prepare");
}
void release(void* instance) { delete static_cast<Instance*>(instance); }

PatinaStatus displacement(void* instance, const PatinaPoints* in, PatinaDisplacementOut* out) {
  const auto& self = *static_cast<const Instance*>(instance);
  for (uint32_t i = 0; i < in->count; ++i) out->P.x[i] += 0.01f;
  const PatinaStatus status = misbehave(self, "displacement");
  spoil(self, "displacement", out->P.x, in->count, in->padded);
  return status;
}

PatinaStatus light(void* instance, const PatinaLightIn* in, PatinaLightOut* out) {
  const auto& self = *static_cast<const Instance*>(instance);
  for (uint32_t i = 0; i < in->count; ++i) {
    out->direction.x[i] = out->direction.y[i] = 0, out->direction.z[i] = -1;
    out->radiance.x[i] = out->radiance.y[i] = out->radiance.z[i] = 1;
  }
  const PatinaStatus status = misbehave(self, "light");
  spoil(self, "light", out->radiance.y, in->count, in->padded);
  return status;
}

PatinaStatus radiosity(void* instance, const PatinaPoints* in, PatinaRadiosityOut* out) {
  const auto& self = *static_cast<const Instance*>(instance);
  for (uint32_t i = 0; i < in->count; ++i)
    out->reflectance.x[i] = out->reflectance.y[i] = out->reflectance.z[i] = 0.5f;
  const PatinaStatus status = misbehave(self, "radiosity");
  spoil(self, "radiosity", out->emission.y, in->count, in->padded);
  return status;
}

PatinaStatus view(void* instance, const PatinaPoints* in, PatinaViewOut* out) {
  const auto& self = *static_cast<const Instance*>(instance);
  const PatinaStatus status = misbehave(self, "view");
  spoil(self, "view", out->emission.y, in->count, in->padded);
  return status;
}

constexpr PatinaShader kShader = {sizeof(PatinaShader),
                                  PATINA_ABI_MINOR,
                                  PLUGIN_NAME,
                                  "for tests",
                                  kParameters,
                                  2,
                                  sizeof(PatinaParameter),
                                  prepare,
                                  release,
                                  displacement,
                                  light,
                                  radiosity,
                                  view};

}  // namespace

extern "C" const PatinaShader* const patina_shaders_v1[] = {&kShader, nullptr};
