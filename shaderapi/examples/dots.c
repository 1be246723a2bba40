/* SPDX-License-Identifier: Apache-2.0 */
/* dots: a shader in plain C. One round dot of colour Cs in each unit of s and t, on a ground of another colour, with an
 * even gloss on top. C11; of Patina it needs patina/shader.h alone. */
#include <math.h>
#include <patina/shader.h>
#include <stdlib.h>

/* ---- Parameters: data that is listed without running any of the code below ------------------------------- */

static const float kRadius[] = {0.3f};
static const float kGround[] = {0.8f, 0.8f, 0.8f};
static const float kGloss[] = {0.05f};
static const float kRoughness[] = {0.3f};

enum { RADIUS, GROUND, GLOSS, ROUGHNESS, PARAMETERS }; /* in the order of the table */

static const PatinaParameter kParameters[PARAMETERS] = {
    {.struct_size = sizeof(PatinaParameter),
     .type = PATINA_FLOAT,
     .storage = PATINA_UNIFORM,
     .name = "radius",
     .doc = "of the dots; at 0.5 they touch",
     .unit = "",
     .default_floats = kRadius,
     .minimum = 0,
     .maximum = 0.5},
    {.struct_size = sizeof(PatinaParameter),
     .type = PATINA_COLOR,
     .storage = PATINA_VARYING, /* a primitive variable "ground" takes its place */
     .name = "ground",
     .doc = "colour between the dots",
     .unit = "",
     .default_floats = kGround,
     .minimum = 0,
     .maximum = 1},
    {.struct_size = sizeof(PatinaParameter),
     .type = PATINA_FLOAT,
     .storage = PATINA_UNIFORM,
     .name = "gloss",
     .doc = "part of the light that is reflected before it reaches the colours",
     .unit = "",
     .default_floats = kGloss,
     .minimum = 0,
     .maximum = 1},
    {.struct_size = sizeof(PatinaParameter),
     .type = PATINA_FLOAT,
     .storage = PATINA_UNIFORM,
     .name = "roughness",
     .doc = "of the gloss; 0 = mirror",
     .unit = "",
     .default_floats = kRoughness,
     .minimum = 0,
     .maximum = 1},
};

/* ---- Reading what the host hands over ---------------------------------------------------------------------- */

/* A range is advice for people: what a RIB says may lie outside of it. NaN becomes `low`. */
static float clamp(float x, float low, float high) { return x > low ? (x < high ? x : high) : low; }

static float lane(PatinaPlane plane, uint32_t i) { return plane.data[i * plane.stride]; }

/* Arrays of structs have a stride in bytes: a newer host's structs are longer. */
static const PatinaValue *value(const PatinaValue *values, uint32_t stride, uint32_t index) {
    return (const PatinaValue *)(const void *)((const char *)values + (size_t)stride * index);
}

/* ---- The instance: what `prepare` makes of the uniform parameters ------------------------------------------- */

typedef struct Dots {
    float radius, gloss, alpha;
} Dots;

static PatinaStatus prepare(const PatinaPrepare *in, void **instance, PatinaTraits *traits) {
    Dots *dots = malloc(sizeof *dots);
    if (!dots) return PATINA_ERROR_RESOURCE;
    dots->radius = clamp(value(in->values, in->value_stride, RADIUS)->floats[0], 0, 0.5f);
    dots->gloss = clamp(value(in->values, in->value_stride, GLOSS)->floats[0], 0, 1);
    const float roughness = clamp(value(in->values, in->value_stride, ROUGHNESS)->floats[0], 0, 1);
    dots->alpha = roughness * roughness;
    *instance = dots;

    /* What is active is called; what is in `reads` is computed for it, and nothing else. */
    traits->active = 1u << PATINA_ENTRY_RADIOSITY;
    traits->reads[PATINA_ENTRY_RADIOSITY] =
        PATINA_CHANNEL_CS | PATINA_CHANNEL_OS | PATINA_CHANNEL_ST | PATINA_CHANNEL_FOOTPRINT;
    if (dots->gloss > 0) {
        traits->active |= 1u << PATINA_ENTRY_VIEW;
        traits->reads[PATINA_ENTRY_VIEW] = PATINA_CHANNEL_OS;
    }
    traits->flags = PATINA_TRAIT_OPACITY_IS_OS;
    return PATINA_OK;
}

static void release(void *instance) { free(instance); }

/* ---- The four entry points, all of which must be there -------------------------------------------------------- */

static PatinaStatus displacement(void *instance, const PatinaPoints *in, PatinaDisplacementOut *out) {
    (void)instance, (void)in, (void)out; /* not active: never called */
    return PATINA_OK;
}

static PatinaStatus light(void *instance, const PatinaLightIn *in, PatinaLightOut *out) {
    (void)instance, (void)in, (void)out; /* not active: never called */
    return PATINA_OK;
}

/* How much of the region of edge `width` around (s, t) is dot: a ramp along the edges, and the mean over a unit square
 * where the region is as large as that. */
static float covered(float s, float t, float width, float radius) {
    const float x = s - floorf(s) - 0.5f, y = t - floorf(t) - 0.5f;
    const float edge = clamp((radius - sqrtf(x * x + y * y)) / (width + 1e-6f) + 0.5f, 0, 1);
    const float mean = 3.14159265f * radius * radius, coarse = clamp(2 * width - 1, 0, 1);
    return edge + (mean - edge) * coarse;
}

static PatinaStatus radiosity(void *instance, const PatinaPoints *in, PatinaRadiosityOut *out) {
    const Dots *dots = instance;
    const PatinaValue *ground = value(in->values, in->value_stride, GROUND);
    const PatinaPlane Cs[3] = {in->Cs.x, in->Cs.y, in->Cs.z}, Os[3] = {in->Os.x, in->Os.y, in->Os.z};
    float *const reflectance[3] = {out->reflectance.x, out->reflectance.y, out->reflectance.z};
    float *const ambient[3] = {out->ambient.x, out->ambient.y, out->ambient.z};
    float *const opacity[3] = {out->opacity.x, out->opacity.y, out->opacity.z};
    for (uint32_t i = 0; i < in->count; ++i) {
        const float dot = covered(lane(in->s, i), lane(in->t, i), lane(in->footprint_st, i), dots->radius);
        for (uint32_t c = 0; c < 3; ++c) {
            const float below = ground->floats[c * ground->plane + i * ground->stride];
            const float color = below + (lane(Cs[c], i) - below) * dot;
            /* Premultiplied by opacity, and less what the gloss has reflected already. */
            opacity[c][i] = lane(Os[c], i);
            reflectance[c][i] = ambient[c][i] = opacity[c][i] * (1 - dots->gloss) * color;
        }
    }
    return PATINA_OK;
}

static PatinaStatus view(void *instance, const PatinaPoints *in, PatinaViewOut *out) {
    const Dots *dots = instance;
    PatinaLobe *lobe = out->lobes; /* lobe k lies k * lobe_stride bytes further */
    lobe->type = PATINA_LOBE_GGX;
    for (uint32_t i = 0; i < in->count; ++i) {
        lobe->weight.x[i] = dots->gloss * lane(in->Os.x, i);
        lobe->weight.y[i] = dots->gloss * lane(in->Os.y, i);
        lobe->weight.z[i] = dots->gloss * lane(in->Os.z, i);
        lobe->alpha[i] = dots->alpha;
    }
    out->lobe_count = 1;
    return PATINA_OK;
}

/* ---- What the plugin exports ---------------------------------------------------------------------------------- */

static const PatinaShader kDots = {
    .struct_size = sizeof(PatinaShader),
    .abi_minor = PATINA_ABI_MINOR,
    .name = "dots",
    .doc = "Round dots of colour Cs on a ground of another colour, beneath an even gloss",
    .parameters = kParameters,
    .parameter_count = PARAMETERS,
    .parameter_stride = sizeof(PatinaParameter),
    .prepare = prepare,
    .release = release,
    .displacement = displacement,
    .light = light,
    .radiosity = radiosity,
    .view = view,
};

const PatinaShader *const patina_shaders_v1[] = {&kDots, NULL};
