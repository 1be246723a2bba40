/* SPDX-License-Identifier: Apache-2.0 */
/* clang-format off */
/* Patina's shader ABI, version 1: plain C, everything that a plugin and the renderer say to each other.
 *
 * A plugin is a shared object that exports one data symbol, `patina_shaders_v1`: a NULL-terminated array of pointers to
 * PatinaShader. The array can be listed without running any code of the plugin. C++ authors include patina/sdk.h, which
 * wraps all of this.
 *
 * Conventions
 *   Space      Points, directions and normals are in world space, lengths in its units, unless a parameter says otherwise.
 *   Colour     Linear Rec.709. Radiance in W/(m^2 sr), or whatever unit the lights of the scene are in.
 *   Batches    Structure of arrays. A plane is one component of all lanes: lane i is data[i * stride]; stride 0 = one
 *              value for all lanes, stride 1 = one value per lane. Planes of stride 1 and all output planes are 64-byte
 *              aligned and may be read and written up to `padded` lanes, a multiple of PATINA_LANES; lanes past `count`
 *              hold valid numbers, and what is written there is ignored.
 *   Memory     Who makes it frees it. Pointers handed to an entry point are valid during the call only, those handed to
 *              `prepare` until `release`. Strings are UTF-8 and zero-terminated.
 *   Threads    [main] = one thread at a time per instance; [any] = from any thread, several at a time on one instance.
 *              An entry point must not keep state between calls: its results depend on its arguments alone.
 *   Growth     Structs carry their size and only grow at the end; enums and bit sets are only appended to. Whoever reads
 *              a struct reads no further than struct_size. Arrays of structs come with a stride in bytes.
 *   Errors     Entry points return a PatinaStatus; no C++ exception, type or allocation may cross this edge.
 */
#ifndef PATINA_SHADER_H
#define PATINA_SHADER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define PATINA_ABI_MAJOR 1u /* in the symbol's name; differs = refused */
#define PATINA_ABI_MINOR 4u /* newer plugins run with older hosts of the same major version */
#define PATINA_LANES 16u
#define PATINA_MAX_LOBES 8u
#define PATINA_LOBE_DATA 16u /* numbers that a custom lobe may take from `view`, at most */
#define PATINA_MAX_RAYS 256u /* that an entry point may trace for one point, at most */

typedef int32_t PatinaStatus;
enum {
    PATINA_OK = 0,
    PATINA_ERROR_PARAMETER = 1, /* a parameter's value makes no sense */
    PATINA_ERROR_RESOURCE = 2,  /* a file, memory ... could not be had */
    PATINA_ERROR_INTERNAL = 3
};

/* ---- Planes ---------------------------------------------------------------------------------------------------- */

typedef struct PatinaPlane {
    const float *data; /* NULL: the channel is not there (the traits did not ask for it) */
    uint32_t stride;   /* 0 or 1 */
    uint32_t reserved;
} PatinaPlane;

typedef struct PatinaPlane3 { PatinaPlane x, y, z; } PatinaPlane3;

typedef struct PatinaOut3 { float *x, *y, *z; } PatinaOut3;

/* ---- Parameters ------------------------------------------------------------------------------------------------ */

typedef enum PatinaType {
    PATINA_FLOAT = 1, PATINA_INT = 2, PATINA_STRING = 3, PATINA_COLOR = 4, PATINA_POINT = 5,
    PATINA_VECTOR = 6, PATINA_NORMAL = 7, PATINA_MATRIX = 8, PATINA_HPOINT = 9
} PatinaType;

typedef enum PatinaStorage {
    PATINA_UNIFORM = 1, /* one value per shader instance */
    PATINA_VARYING = 2  /* a primitive variable of the same name takes its place, interpolated at each lane */
} PatinaStorage;

typedef struct PatinaParameter {
    uint32_t struct_size;
    uint32_t type;         /* PatinaType */
    uint32_t storage;      /* PatinaStorage; strings and ints are always uniform */
    uint32_t array_length; /* 0 = not an array */
    const char *name;
    const char *doc;  /* one line */
    const char *unit; /* "" = none */
    /* Defaults: component by component, array elements one after the other. Exactly one of the three is not NULL. */
    const float *default_floats; /* points, vectors, normals: in shader space, as those of a RIB are */
    const int32_t *default_ints;
    const char *const *default_strings;
    double minimum, maximum; /* range that makes sense, per component; minimum > maximum = any */
} PatinaParameter;

/* The value of one parameter. Component c (array element e: c + e * components) of lane i is
 * floats[component * plane + i * stride]. Points, vectors and normals arrive in world space, be they set or defaults.
 * Ints and strings may be NULL where the type has none. */
typedef struct PatinaValue {
    const float *floats;
    const int32_t *ints;        /* uniform */
    const char *const *strings; /* uniform */
    uint32_t stride;            /* 0 or 1 */
    uint32_t plane;             /* distance of two components in floats */
    uint32_t count;             /* components in all: 1, 3, 4 or 16 times the array length */
    uint32_t is_set;            /* 0 = the default */
} PatinaValue;

/* ---- What a batch consists of ---------------------------------------------------------------------------------- */

/* Bits of PatinaTraits.reads: which channels of PatinaPoints an entry point reads; the rest may be NULL. */
#define PATINA_CHANNEL_P         (UINT64_C(1) << 0)
#define PATINA_CHANNEL_N         (UINT64_C(1) << 1)
#define PATINA_CHANNEL_NG        (UINT64_C(1) << 2)
#define PATINA_CHANNEL_DPDU      (UINT64_C(1) << 3)
#define PATINA_CHANNEL_DPDV      (UINT64_C(1) << 4)
#define PATINA_CHANNEL_UV        (UINT64_C(1) << 5)
#define PATINA_CHANNEL_ST        (UINT64_C(1) << 6)
#define PATINA_CHANNEL_FOOTPRINT (UINT64_C(1) << 7)
#define PATINA_CHANNEL_CS        (UINT64_C(1) << 8)
#define PATINA_CHANNEL_OS        (UINT64_C(1) << 9)
#define PATINA_CHANNEL_I         (UINT64_C(1) << 10) /* only `view` may ask for it */
#define PATINA_CHANNEL_TIME      (UINT64_C(1) << 11)
#define PATINA_CHANNEL_DPDS      (UINT64_C(1) << 12)
#define PATINA_CHANNEL_DPDT      (UINT64_C(1) << 13)

/* Points on a surface. */
typedef struct PatinaPoints {
    uint32_t struct_size;
    uint32_t count;
    uint32_t padded;
    uint32_t value_stride;      /* bytes from one PatinaValue to the next */
    const PatinaValue *values;  /* one per parameter, in the order of the shader's table */
    PatinaPlane3 P;             /* position */
    PatinaPlane3 N;             /* unit shading normal; on the side that is shaded */
    PatinaPlane3 Ng;            /* unit geometric normal; same side */
    PatinaPlane3 dPdu, dPdv;    /* derivatives of P by the surface's own u and v */
    PatinaPlane u, v;           /* surface parameters */
    PatinaPlane s, t;           /* texture coordinates */
    PatinaPlane footprint;      /* width of the region that the point stands for, world units; 0 = a point */
    PatinaPlane footprint_st;   /* the same width in s, t units */
    PatinaPlane3 Cs, Os;        /* surface colour and opacity */
    PatinaPlane time;           /* seconds, within the shutter */
    PatinaPlane3 I;             /* unit, from the viewer to P, as in RI. Only for `view`; NULL planes for every
                                   other entry point */
    /* Since minor version 4. */
    PatinaPlane3 dPds, dPdt;    /* derivatives of P by s and t; dPdu and dPdv where those do not span the surface */
} PatinaPoints;

/* ---- displacement ---------------------------------------------------------------------------------------------- */

typedef struct PatinaDisplacementOut {
    uint32_t struct_size;
    uint32_t writes_normal; /* the plugin sets it to 1 when it has filled N; else the host recomputes normals */
    PatinaOut3 P;           /* filled with the undisplaced position before the call */
    PatinaOut3 N;           /* unit, filled with the undisplaced normal before the call */
} PatinaDisplacementOut;

/* ---- light ----------------------------------------------------------------------------------------------------- */

typedef enum PatinaLightKind {
    PATINA_LIGHT_NONE = 0,
    PATINA_LIGHT_AMBIENT = 1,     /* adds Cl to every point, no direction, never occluded */
    PATINA_LIGHT_DELTA = 2,       /* one direction per point: point, spot, parallel light */
    PATINA_LIGHT_INFINITE = 3,    /* radiance from directions: sky, sun disc; sampled by the plugin */
    PATINA_LIGHT_AREA = 4         /* radiance from the geometry that it is bound to; sampled by the host */
} PatinaLightKind;

typedef enum PatinaLightTask {
    PATINA_LIGHT_SAMPLE = 1,   /* P, random -> direction, distance, radiance, pdf   (AMBIENT, DELTA, INFINITE) */
    PATINA_LIGHT_EVALUATE = 2, /* P, direction -> radiance, pdf                     (INFINITE) */
    PATINA_LIGHT_EMIT = 3      /* P, N, u, v, direction -> radiance                 (AREA) */
} PatinaLightTask;

typedef struct PatinaLightIn {
    uint32_t struct_size;
    uint32_t count;
    uint32_t padded;
    uint32_t task;             /* PatinaLightTask */
    const PatinaValue *values;
    uint32_t value_stride;
    uint32_t reserved;
    PatinaPlane3 P;            /* SAMPLE, EVALUATE: the point to be lit. EMIT: the point on the light */
    PatinaPlane3 N;            /* EMIT: unit normal of the light's outside at P */
    PatinaPlane3 direction;    /* EVALUATE: unit, from P towards the light. EMIT: unit, from the light to what is lit */
    PatinaPlane u, v;          /* EMIT: the light's surface parameters */
    PatinaPlane random_x, random_y; /* SAMPLE: uniform in [0,1) */
    PatinaPlane time;
} PatinaLightIn;

typedef struct PatinaLightOut {
    uint32_t struct_size;
    uint32_t reserved;
    PatinaOut3 direction; /* SAMPLE: unit, from P towards the light */
    float *distance;      /* SAMPLE: to the light, world units; PATINA_INFINITE_DISTANCE for light from infinity */
    PatinaOut3 radiance;  /* AMBIENT, DELTA: RI's Cl, that is irradiance on a facing surface divided by pi.
                             INFINITE, AREA: radiance */
    float *pdf;           /* INFINITE: of the direction, per solid angle; 0 = no light in this sample. Others: unused */
} PatinaLightOut;

#define PATINA_INFINITE_DISTANCE 1.0e30f

/* ---- radiosity: what the surface does with light, seen from no direction in particular ------------------------- */

/* The host adds E = irradiance on the front and back (lights and indirect light) and forms the outgoing radiance
 *     B = emission + ambient * sum(Cl of ambient lights) + reflectance * E(front)/pi + transmittance * E(back)/pi
 * which is what the radiosity cache keeps. All planes are zero before the call, opacity is one. */
typedef struct PatinaRadiosityOut {
    uint32_t struct_size;
    uint32_t reserved;
    PatinaOut3 emission;      /* radiance */
    PatinaOut3 reflectance;   /* diffuse, rho in [0,1] */
    PatinaOut3 transmittance; /* diffuse, tau in [0,1] */
    PatinaOut3 ambient;       /* weight of ambient lights (RI's Ka) */
    PatinaOut3 opacity;       /* 1 = opaque; emission ... ambient are premultiplied by it, as RI's Ci is by Oi.
                                 Where `radiosity` is not active: one, or Os with PATINA_TRAIT_OPACITY_IS_OS */
} PatinaRadiosityOut;

/* ---- view: what depends on the direction of view --------------------------------------------------------------- */

typedef enum PatinaLobeType {
    PATINA_LOBE_NONE = 0,
    PATINA_LOBE_RI_SPECULAR = 1, /* RI specular(): Cl * (N.H)^(8/roughness), roughness in `alpha`; H halfway to the light */
    PATINA_LOBE_GGX = 2,         /* microfacet reflection, GGX with height-correlated Smith G; alpha 0 = mirror; F = 1 */
    PATINA_LOBE_DIELECTRIC = 3,  /* Fresnel reflection and refraction, `eta` = ior inside / outside of the surface (the
                                    host knows which side is seen, and inverts it there); alpha 0 = smooth;
                                    `weight` scales reflection, `transmission` refraction */
    PATINA_LOBE_CUSTOM = 1024    /* and above: the plugin's own, as numbered by PatinaLobeRegistry.add. `weight` scales
                                    its f, and its luminance is how often it is chosen: best the share of light that
                                    it scatters; `alpha` is how wide it is, as of GGX; `transmission` is not used */
} PatinaLobeType;

typedef struct PatinaLobe {
    uint32_t struct_size;
    uint32_t type;           /* PatinaLobeType, the same for all lanes; set by the plugin */
    PatinaOut3 weight;       /* zero before the call */
    PatinaOut3 transmission; /* zero before the call */
    float *alpha;            /* zero before the call */
    float *eta;              /* one before the call */
    /* Since minor version 2. What a custom lobe needs to know of the point: planes, zero before the call, as many as
     * the instance's lobes take at most; NULL and 0 if it registered none. */
    float *const *data;
    uint32_t data_count;
    uint32_t reserved;
} PatinaLobe;

typedef struct PatinaViewOut {
    uint32_t struct_size;
    uint32_t lobe_count;     /* set by the plugin: how many of `lobes` it filled, from the first */
    PatinaOut3 emission;     /* view-dependent radiance, added to that of `radiosity` for the camera and specular rays;
                                diffuse rays, which carry no view, never see it. Zero before the call */
    PatinaLobe *lobes;       /* PATINA_MAX_LOBES of them */
    uint32_t lobe_stride;    /* bytes from one lobe to the next */
    uint32_t reserved;
} PatinaViewOut;

/* ---- Host services --------------------------------------------------------------------------------------------- */

typedef enum PatinaReport { PATINA_REPORT_INFO = 0, PATINA_REPORT_WARNING = 1, PATINA_REPORT_ERROR = 2 } PatinaReport;

typedef struct PatinaTexture PatinaTexture; /* a texture file, opened; owned by the host */

typedef struct PatinaHost {
    uint32_t struct_size;
    uint32_t abi_minor;
    void *host; /* first argument of every function below */
    /* [any] A message of this plugin. Counted per code; printed once, with its count and the RIB line of the shader. */
    void (*report)(void *host, PatinaReport severity, int32_t code, const char *message);
    /* [main] The matrix (row vectors: p' = p M) from coordinate system `from` to `to`: "world", "camera", "shader",
     * "object" or a name given by CoordinateSystem. 0 = not known, and the identity. */
    int32_t (*transform)(void *host, const char *from, const char *to, float matrix[16]);
    /* [main] Opens a texture of colours by its search-path name: they arrive as linear Rec.709. A name with <UDIM> is a
     * set of tiles. NULL = not found, which has been reported. Textures of data: PATINA_EXTENSION_DATA_TEXTURES. */
    PatinaTexture *(*open_texture)(void *host, const char *name);
    /* [any] Filtered look-up: `width` in s, t units, t = 0 is the top row; s and t wrap around unless the file was made
     * otherwise (MakeTexture), or choose a tile of a set. `alpha` may be NULL. A NULL texture reads 1. Missing channels
     * of the file repeat its first (grey) or read 1 (alpha). */
    PatinaStatus (*texture)(void *host, PatinaTexture *texture, uint32_t count, PatinaPlane s, PatinaPlane t,
                            PatinaPlane width, PatinaOut3 color, float *alpha);
    /* [any] Look-up by direction (any length but zero) in a latitude-longitude picture. As in RI, +z is up and longitude
     * runs around it: s = 0.5 + atan2(y, x) / 2 pi, t = acos(z) / pi, so that the top row is +z. `width` in radians. */
    PatinaStatus (*environment)(void *host, PatinaTexture *texture, uint32_t count, PatinaPlane3 direction,
                                PatinaPlane width, PatinaOut3 color);
    /* [any] The size of a texture in pixels; channels. */
    PatinaStatus (*texture_size)(void *host, PatinaTexture *texture, uint32_t *width, uint32_t *height,
                                 uint32_t *channels);
    /* [any] An optional interface by id, one of PATINA_EXTENSION_ below; NULL when the host does not have it. Its functions
     * take PatinaHost.host as their first argument. */
    const void *(*extension)(void *host, const char *id);
} PatinaHost;

/* ---- Extension: custom lobes ----------------------------------------------------------------------------------- */

/* A lobe of the plugin's own, as part of what `view` gives. The host evaluates it for light, samples it, weighs both by
 * their densities, and never asks for its own lobes' formulas. The functions have no state: they know the instance and
 * what `view` wrote to PatinaLobe.data at the point, all else is in their arguments. What is not finite or negative
 * counts as black, and is counted as other outputs are.
 *
 *   prepare:  const PatinaLobeRegistry *lobes = host->extension(host->host, PATINA_EXTENSION_CUSTOM_LOBES);
 *             if (lobes) type = lobes->add(host->host, &kSheen);      NULL: the host has no custom lobes
 *   view:     lobe->type = type; lobe->weight ...; lobe->data[0][i] = roughness; ... */
#define PATINA_EXTENSION_CUSTOM_LOBES "patina.custom_lobes.1"

typedef struct PatinaLobeIn {
    uint32_t struct_size;
    uint32_t count;
    uint32_t padded;
    uint32_t data_count;
    const PatinaPlane *data; /* data_count planes: what `view` wrote */
    PatinaPlane3 N;          /* unit, the lobe's axis: the shading normal, bent to wo . N > 0 */
    PatinaPlane3 wo;         /* unit, to the viewer */
    PatinaPlane3 wi;         /* evaluate: unit, to the light. sample: NULL planes */
    PatinaPlane random_x, random_y; /* sample: uniform in [0,1). evaluate: NULL */
    PatinaPlane alpha, eta;  /* as `view` gave them; eta inverted where the inside is seen */
} PatinaLobeIn;

typedef struct PatinaLobeOut {
    uint32_t struct_size;
    uint32_t reserved;
    PatinaOut3 f;  /* evaluate: the BSDF times |wi . N|, sr^-1: of light from all sides 1 is scattered at most */
    float *pdf;    /* evaluate: how densely `sample` gives wi, sr^-1, over all directions; 1 in all, less the share of
                      samples that give none */
    PatinaOut3 wi; /* sample: unit, away from the point; zero = none. Zero before the call */
} PatinaLobeOut;

#define PATINA_LOBE_REFLECTS       (1u << 0) /* to the viewer's side of the surface: wi . N > 0 */
#define PATINA_LOBE_TRANSMITS      (1u << 1) /* through it: wi . N < 0 */
#define PATINA_LOBE_NOT_RECIPROCAL (1u << 2) /* f / |wi . N| may change when wo and wi change places */

typedef struct PatinaCustomLobe {
    uint32_t struct_size;
    uint32_t flags;      /* PATINA_LOBE_ bits: which directions it is asked for; at least one side */
    const char *name;
    const char *doc;     /* one line */
    uint32_t data_count; /* numbers that it takes from PatinaLobe.data, from the first; at most PATINA_LOBE_DATA */
    uint32_t reserved;
    PatinaStatus (*evaluate)(void *instance, const PatinaLobeIn *in, PatinaLobeOut *out); /* [any] f and pdf of wi */
    PatinaStatus (*sample)(void *instance, const PatinaLobeIn *in, PatinaLobeOut *out);   /* [any] wi by pdf */
} PatinaCustomLobe;

typedef struct PatinaLobeRegistry {
    uint32_t struct_size;
    uint32_t reserved;
    /* [main] Only within `prepare`. `lobe` is valid until `release`. The type of the lobe in this instance's `view`; 0 =
     * refused, and the shader fails with the reason. At most PATINA_MAX_LOBES. */
    uint32_t (*add)(void *host, const PatinaCustomLobe *lobe);
} PatinaLobeRegistry;

/* ---- The shader ------------------------------------------------------------------------------------------------ */

typedef enum PatinaEntry {
    PATINA_ENTRY_DISPLACEMENT = 0, PATINA_ENTRY_LIGHT = 1, PATINA_ENTRY_RADIOSITY = 2, PATINA_ENTRY_VIEW = 3
} PatinaEntry;
#define PATINA_ENTRIES 4u

#define PATINA_TRAIT_OPAQUE        (UINT64_C(1) << 0) /* opacity is one everywhere: never asked for */
#define PATINA_TRAIT_EMITS         (UINT64_C(1) << 1) /* emission may differ from zero */
#define PATINA_TRAIT_NOT_CACHEABLE (UINT64_C(1) << 2) /* radiosity changes within a footprint in a way no vertex shows */
#define PATINA_TRAIT_TRANSMITS     (UINT64_C(1) << 3) /* transmittance may differ from zero */
#define PATINA_TRAIT_BLACK         (UINT64_C(1) << 4) /* reflectance and transmittance are zero: needs no irradiance */
#define PATINA_TRAIT_UNSHADOWED    (UINT64_C(1) << 5) /* a light that nothing occludes */
#define PATINA_TRAIT_TWO_SIDED     (UINT64_C(1) << 6) /* an area light that emits from both sides */
#define PATINA_TRAIT_CAMERA_VISIBLE (UINT64_C(1) << 7) /* an infinite light that the camera sees */
#define PATINA_TRAIT_OPACITY_IS_OS (UINT64_C(1) << 8) /* opacity is the channel Os: known, and opaque where Os is one,
                                                         without a call */
#define PATINA_TRAIT_TRANSPARENT   (UINT64_C(1) << 9) /* opacity is zero and emission black everywhere: rays pass as if
                                                         the surface was not there */
#define PATINA_TRAIT_SMOOTH        (UINT64_C(1) << 10) /* an infinite light whose radiance hardly changes with the direction:
                                                          surfaces sample it better than it does itself */
#define PATINA_TRAIT_FROM_POINT    (UINT64_C(1) << 11) /* a DELTA light that shines from light_from alone, falls off with
                                                          the square of the distance, and is black outside its cone */
#define PATINA_TRAIT_PER_AREA      (UINT64_C(1) << 12) /* an AREA light of which the host divides what `light` gives, and
                                                          light_power, by the area of its geometry in world units */

/* What `prepare` found out from the parameters. Zeroed by the host before the call but for struct_size. Traits hold for
 * every batch: they may depend on uniform parameters only, for a primitive variable may replace a varying one. */
typedef struct PatinaTraits {
    uint32_t struct_size;
    uint32_t active;                 /* bit (1 << PatinaEntry): the entry point does something; others are never called */
    uint64_t reads[4];               /* by PatinaEntry: PATINA_CHANNEL_ bits */
    uint64_t flags;                  /* PATINA_TRAIT_ bits */
    float displacement_bound;        /* world units: P never moves further; 0 = not said, the host finds out */
    uint32_t light_kind;             /* PatinaLightKind */
    float light_power;               /* a guess at relative emitted power, to choose among lights; 0 = unknown. Of AREA lights
                                        the mean radiance: the host knows their area */
    uint32_t reserved;
    /* Since minor version 1. With PATINA_TRAIT_FROM_POINT, world space; lights without it may shine from anywhere. */
    float light_from[3];
    float light_axis[3];             /* of the cone, of any length; zero: it shines all around */
    float light_cone;                /* radians from light_axis to where there is no light any more */
    uint32_t reserved2;
} PatinaTraits;

/* What `prepare` is given. Varying parameters hold their uniform value or default. */
typedef struct PatinaPrepare {
    uint32_t struct_size;
    uint32_t value_stride;
    const PatinaHost *host;          /* valid until `release` */
    const PatinaValue *values;       /* valid until `release` */
    float world_to_shader[16];       /* row vectors; "shader" space is that of the Surface/LightSource request */
    float shader_to_world[16];
} PatinaPrepare;

typedef struct PatinaShader {
    uint32_t struct_size;
    uint32_t abi_minor;         /* PATINA_ABI_MINOR at the plugin's compile time */
    const char *name;
    const char *doc;            /* one line */
    const PatinaParameter *parameters;
    uint32_t parameter_count;
    uint32_t parameter_stride;  /* sizeof(PatinaParameter) at the plugin's compile time */
    /* [main] Called once per binding. Writes the instance pointer (may stay NULL) and the traits. Must not be NULL. */
    PatinaStatus (*prepare)(const PatinaPrepare *in, void **instance, PatinaTraits *traits);
    void (*release)(void *instance); /* [main] may be NULL. Called once after each `prepare` that returned PATINA_OK or
                                        wrote an instance */
    /* The four entry points, all mandatory: a shader without one of them is refused. [any] */
    PatinaStatus (*displacement)(void *instance, const PatinaPoints *in, PatinaDisplacementOut *out);
    PatinaStatus (*light)(void *instance, const PatinaLightIn *in, PatinaLightOut *out);
    PatinaStatus (*radiosity)(void *instance, const PatinaPoints *in, PatinaRadiosityOut *out);
    PatinaStatus (*view)(void *instance, const PatinaPoints *in, PatinaViewOut *out);
} PatinaShader;

#if defined(__GNUC__)
#define PATINA_EXPORT __attribute__((visibility("default")))
#else
#define PATINA_EXPORT
#endif

/* A plugin defines this: { &first, &second, ..., NULL }. */
extern PATINA_EXPORT const PatinaShader *const patina_shaders_v1[];

/* ---- Extension: textures of data ------------------------------------------------------------------------------- */

/* Heights, weights, normals ...: values that are no colours and are never converted from a colour space. */
#define PATINA_EXTENSION_DATA_TEXTURES "patina.data_textures.1"
typedef struct PatinaDataTextures {
    uint32_t struct_size;
    uint32_t reserved;
    /* [main] As PatinaHost.open_texture, whose first argument it takes; the texture is looked up in the same way. */
    PatinaTexture *(*open)(void *host, const char *name);
} PatinaDataTextures;

/* ---- Extension: atmosphere ------------------------------------------------------------------------------------- */

/* What lies between the eye and the surfaces that it sees: RI's Atmosphere. Such a shader hands its function to the host in
 * `prepare`; its other entry points are not called. Every surface seen has one segment of the ray, which begins at
 * the eye or at the surface before, through which the eye saw it. What is seen over a segment is
 *     Ci' = transmittance * Ci + radiance,  Oi' = 1 - transmittance * (1 - Oi)
 * so that RI's mix(Ci, background, d) is transmittance 1 - d with radiance d * background. */
#define PATINA_EXTENSION_ATMOSPHERE "patina.atmosphere.1"
typedef struct PatinaAtmosphereIn {
    uint32_t struct_size;
    uint32_t count;
    uint32_t padded;
    uint32_t reserved;
    PatinaPlane3 origin;      /* of the segment */
    PatinaPlane3 direction;   /* unit, away from the eye */
    PatinaPlane length;       /* world units */
    PatinaPlane depth_origin; /* RI's depth() where the segment begins: 0 at the near clipping plane, 1 at the far one;
                                 -PATINA_INFINITE_DISTANCE at the eye */
    PatinaPlane depth;        /* and where it ends */
} PatinaAtmosphereIn;
typedef struct PatinaAtmosphereOut {
    uint32_t struct_size;
    uint32_t reserved;
    PatinaOut3 transmittance; /* in [0,1]; one before the call */
    PatinaOut3 radiance;      /* added; zero before the call */
} PatinaAtmosphereOut;
typedef PatinaStatus (*PatinaAtmosphereFunction)(void *instance, const PatinaAtmosphereIn *in, PatinaAtmosphereOut *out);
typedef struct PatinaAtmospheres {
    uint32_t struct_size;
    uint32_t reserved;
    /* [main] In `prepare` alone: `function` [any] is to be called, with the instance that `prepare` writes. `host` as
     * PatinaHost.host. */
    void (*set)(void *host, PatinaAtmosphereFunction function);
} PatinaAtmospheres;

/* ---- Extension: files ------------------------------------------------------------------------------------------ */

/* Files that are no textures, found where a scene has them. */
#define PATINA_EXTENSION_FILES "patina.files.1"

typedef struct PatinaFiles {
    uint32_t struct_size;
    uint32_t reserved;
    /* [main] The path of `name`, which a scene gives as a shader's argument: beside the file of the request that binds the
     * shader, else as it is. NULL = there is no such file, or the scene may not read it. Only regular files are found. In
     * `prepare` alone; the string is the host's and lives until the next call. */
    const char *(*find)(void *host, const char *name);
} PatinaFiles;

/* ---- Extension: rays ------------------------------------------------------------------------------------------- */

/* What is near a point: hollows, edges, occlusion. Rays meet the geometry alone, as it is when the shutter opens and as far
 * as diffuse rays see it (RI: Attribute "visibility" "diffuse"). No shader is run for what they meet: every surface counts
 * as opaque. What a ray meets is a property of the scene, the same for every call, so that `radiosity` may be cached.
 *
 * The cost is declared in `prepare`, entry point by entry point, and kept: a call that would exceed it for any point of the
 * batch is refused as a whole, and reported. Of `radiosity` count on each vertex of the cache, and on each hit that is
 * shaded directly: some tens of rays per point are much. The host counts them (Shaders/NAME/radiosity/rays). */
#define PATINA_EXTENSION_RAYS "patina.rays.1"

/* The planes are the plugin's: of any alignment, with `count` numbers and no padding. */
typedef struct PatinaRayIn {
    uint32_t struct_size;
    uint32_t count;         /* of rays */
    const uint32_t *lane;   /* by ray: the point of the batch that it is for, below PatinaPoints.count; in any order */
    PatinaPlane3 origin;    /* NULL planes: P of that point; then the ray does not meet the surface there */
    PatinaPlane3 direction; /* of any length but zero */
    PatinaPlane maximum;    /* world units: how far the ray reaches. 0 or less: it is not traced, and costs nothing */
} PatinaRayIn;

typedef struct PatinaRayOut {
    uint32_t struct_size;
    uint32_t reserved;
    float *distance; /* to what is met first, world units; PATINA_INFINITE_DISTANCE = nothing. NULL: is not asked for */
    float *occluded; /* 1 = something is met, 0 = nothing. NULL: is not asked for. Alone it is the cheaper question */
} PatinaRayOut;

typedef struct PatinaRays {
    uint32_t struct_size;
    uint32_t reserved;
    /* [main] In `prepare` alone: `entry`, PATINA_ENTRY_RADIOSITY or PATINA_ENTRY_VIEW, traces up to `most` rays for each
     * point, 0 to PATINA_MAX_RAYS; without it none. 0 = refused, and the shader fails with the reason. */
    int32_t (*declare)(void *host, PatinaEntry entry, uint32_t most);
    /* [any] In an entry point that has declared rays, by the thread that it was called in. All rays of a batch in one call
     * cost the least. Rays that are not finite meet nothing, and are reported. */
    PatinaStatus (*trace)(void *host, const PatinaRayIn *in, PatinaRayOut *out);
} PatinaRays;

/* ---- Extension: user attributes -------------------------------------------------------------------------------- */

/* What a scene says of its objects in its own words: RI's Attribute "user" "float wetness" [0.3]. Points, vectors, normals
 * and matrices come as they were given. */
#define PATINA_EXTENSION_ATTRIBUTES "patina.attributes.1"

typedef struct PatinaAttributes {
    uint32_t struct_size;
    uint32_t reserved;
    /* [main] In `prepare` alone: the attribute as it was where the request binds the shader. 0 = there is none of this name
     * that has this PatinaType and array length (0 = not an array), and `value` is as it was. Its memory lives until
     * `release`. */
    int32_t (*get)(void *host, const char *name, uint32_t type, uint32_t array_length, PatinaValue *value);
    /* [main] In `prepare` alone: on every primitive that has the attribute, it takes the place of the shader's varying
     * parameter `parameter`; a primitive variable of the parameter's name goes before. Type and array length have to be
     * the parameter's, or int for a float. 0 = there is no such varying parameter. */
    int32_t (*bind)(void *host, const char *name, const char *parameter);
} PatinaAttributes;

#ifdef __cplusplus
}
#endif

#endif
