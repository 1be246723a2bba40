/* SPDX-License-Identifier: Apache-2.0 */
/* Surfaces that give garbage in some squares of a board of 8 x 8 over s and t: values that are no numbers,
 * not finite, negative or huge. "garbage" gives them in every term; "mended" gives what the renderer is to
 * make of that; "misfit" is good but must not be cached. All complain when `radiosity` is given I, or `view`
 * is not. "garbagelight" is a light whose Cl, direction or distance is garbage in some places. */
#include <math.h>
#include <patina/shader.h>
#include <stddef.h>

enum { kGivenI = 77, kNotGivenI = 78 };

static PatinaStatus prepare(const PatinaPrepare* in, void** instance, PatinaTraits* traits, uint64_t flags) {
  *instance = (void*)in->host;
  traits->active = 1u << PATINA_ENTRY_RADIOSITY | 1u << PATINA_ENTRY_VIEW;
  traits->reads[PATINA_ENTRY_RADIOSITY] = PATINA_CHANNEL_ST;
  traits->reads[PATINA_ENTRY_VIEW] = PATINA_CHANNEL_ST | PATINA_CHANNEL_I;
  traits->flags = PATINA_TRAIT_EMITS | PATINA_TRAIT_TRANSMITS | flags;
  return PATINA_OK;
}
static PatinaStatus prepareGarbage(const PatinaPrepare* in, void** instance, PatinaTraits* traits) {
  return prepare(in, instance, traits, 0);
}
static PatinaStatus prepareMisfit(const PatinaPrepare* in, void** instance, PatinaTraits* traits) {
  return prepare(in, instance, traits, PATINA_TRAIT_NOT_CACHEABLE);
}

static void set(PatinaOut3 to, uint32_t i, float r, float g, float b) {
  to.x[i] = r, to.y[i] = g, to.z[i] = b;
}

/* The square that a lane is in: 0 to 63. */
static int squareOf(const PatinaPoints* in, uint32_t i) {
  const float s = in->s.data[i * in->s.stride], t = in->t.data[i * in->t.stride];
  const int column = (int)(s * 8), row = (int)(t * 8);
  return (column < 0 ? 0 : column > 7 ? 7 : column) + 8 * (row < 0 ? 0 : row > 7 ? 7 : row);
}

static void fill(const PatinaPoints* in, PatinaRadiosityOut* out) {
  for (uint32_t i = 0; i < in->count; ++i) {
    set(out->reflectance, i, 0.5f, 0.4f, 0.3f);
    set(out->opacity, i, 0.8f, 0.8f, 0.8f);
    set(out->emission, i, 0.1f, 0.1f, 0.1f);
  }
}
static void complain(void* instance, const PatinaPoints* in) {
  const PatinaHost* host = instance;
  if (in->I.x.data || in->I.y.data || in->I.z.data)
    host->report(host->host, PATINA_REPORT_ERROR, kGivenI, "radiosity was given I");
}

static PatinaStatus radiosityMisfit(void* instance, const PatinaPoints* in, PatinaRadiosityOut* out) {
  complain(instance, in);
  fill(in, out);
  return PATINA_OK;
}
static PatinaStatus radiosityGarbage(void* instance, const PatinaPoints* in, PatinaRadiosityOut* out) {
  complain(instance, in);
  fill(in, out);
  for (uint32_t i = 0; i < in->count; ++i) switch (squareOf(in, i)) {
      case 3:
        set(out->reflectance, i, NAN, 0.5f, 0.5f);
        break;
      case 10:
        set(out->emission, i, INFINITY, 0, 0);
        break;
      case 17:
        set(out->emission, i, -1e30f, -INFINITY, 0);
        break;
      case 20:
        set(out->reflectance, i, -5, 0.5f, 0.5f);
        break;
      case 29:
        set(out->opacity, i, NAN, 0, 0);
        break;
      case 34:
        set(out->opacity, i, -7, 1e30f, 0);
        break;
      case 43:
        set(out->transmittance, i, 0, -NAN, 0);
        break;
      case 52:
        set(out->emission, i, 0, -3, 0);
        break;
      case 61:
        set(out->ambient, i, NAN, NAN, NAN);
        break;
      default:
        break;
    }
  return PATINA_OK;
}
static PatinaStatus radiosityMended(void* instance, const PatinaPoints* in, PatinaRadiosityOut* out) {
  complain(instance, in);
  fill(in, out);
  for (uint32_t i = 0; i < in->count; ++i) switch (squareOf(in, i)) {
      case 3:
      case 20:
        set(out->reflectance, i, 0, 0, 0);
        break;
      case 10:
      case 17:
      case 52:
        set(out->emission, i, 0, 0, 0);
        break;
      case 29:
      case 34:
        set(out->opacity, i, 1, 1, 1);
        break;
      default:
        break;
    }
  return PATINA_OK;
}

static void complainOfView(void* instance, const PatinaPoints* in) {
  const PatinaHost* host = instance;
  if (!in->I.x.data || !in->I.y.data || !in->I.z.data)
    host->report(host->host, PATINA_REPORT_ERROR, kNotGivenI, "view was not given I");
}
static void fillView(const PatinaPoints* in, PatinaViewOut* out) {
  out->lobe_count = 1;
  out->lobes[0].type = PATINA_LOBE_GGX;
  for (uint32_t i = 0; i < in->count; ++i) {
    set(out->lobes[0].weight, i, 0.1f, 0.1f, 0.1f);
    out->lobes[0].alpha[i] = 0.3f;
  }
}
static PatinaStatus view(void* instance, const PatinaPoints* in, PatinaViewOut* out) {
  complainOfView(instance, in);
  fillView(in, out);
  return PATINA_OK;
}
static PatinaStatus viewGarbage(void* instance, const PatinaPoints* in, PatinaViewOut* out) {
  complainOfView(instance, in);
  fillView(in, out);
  for (uint32_t i = 0; i < in->count; ++i) switch (squareOf(in, i)) {
      case 5:
        set(out->emission, i, NAN, INFINITY, 0);
        break;
      case 12:
        set(out->emission, i, -2, 0, 0);
        break;
      case 26:
        set(out->lobes[0].weight, i, NAN, 1, 1);
        break;
      case 38:
        set(out->lobes[0].weight, i, -1, -1, -1);
        break;
      case 47:
        out->lobes[0].alpha[i] = NAN;
        break;
      case 58:
        out->lobes[0].alpha[i] = -3;
        break;
      default:
        break;
    }
  return PATINA_OK;
}
static PatinaStatus viewMended(void* instance, const PatinaPoints* in, PatinaViewOut* out) {
  complainOfView(instance, in);
  fillView(in, out);
  for (uint32_t i = 0; i < in->count; ++i) switch (squareOf(in, i)) {
      case 26:
      case 38:
        set(out->lobes[0].weight, i, 0, 0, 0);
        break;
      case 47:
      case 58:
        out->lobes[0].alpha[i] = 0;
        break;
      default:
        break;
    }
  return PATINA_OK;
}

static PatinaStatus displacement(void* instance, const PatinaPoints* in, PatinaDisplacementOut* out) {
  return (void)instance, (void)in, (void)out, PATINA_OK;
}
static PatinaStatus light(void* instance, const PatinaLightIn* in, PatinaLightOut* out) {
  return (void)instance, (void)in, (void)out, PATINA_OK;
}

static PatinaStatus prepareLight(const PatinaPrepare* in, void** instance, PatinaTraits* traits) {
  (void)in, (void)instance;
  traits->active = 1u << PATINA_ENTRY_LIGHT;
  traits->light_kind = PATINA_LIGHT_DELTA;
  traits->light_power = 1;
  return PATINA_OK;
}
static PatinaStatus lightGarbage(void* instance, const PatinaLightIn* in, PatinaLightOut* out) {
  (void)instance;
  for (uint32_t i = 0; i < in->count; ++i) {
    set(out->direction, i, 0, 1, 0);
    set(out->radiance, i, 0.5f, 0.5f, 0.5f);
    const float x = in->P.x.data[i * in->P.x.stride] * 4;
    const int strip = (int)floorf(x) & 3;
    if (strip == 0) set(out->radiance, i, NAN, 1, 1);
    if (strip == 1) set(out->direction, i, INFINITY, NAN, 0);
    if (strip == 2) out->distance[i] = NAN;
  }
  return PATINA_OK;
}

#define SHADER(NAME, PREPARE, LIGHT, RADIOSITY, VIEW)                                                     \
  {                                                                                                       \
    sizeof(PatinaShader), PATINA_ABI_MINOR, NAME, "for tests", NULL, 0, sizeof(PatinaParameter), PREPARE, \
        NULL, displacement, LIGHT, RADIOSITY, VIEW                                                        \
  }
static const PatinaShader kGarbage = SHADER("garbage", prepareGarbage, light, radiosityGarbage, viewGarbage);
static const PatinaShader kMended = SHADER("mended", prepareGarbage, light, radiosityMended, viewMended);
static const PatinaShader kMisfit = SHADER("misfit", prepareMisfit, light, radiosityMisfit, view);
static const PatinaShader kLight = SHADER("garbagelight", prepareLight, lightGarbage, radiosityMisfit, view);
const PatinaShader* const patina_shaders_v1[] = {&kGarbage, &kMended, &kMisfit, &kLight, NULL};
