// SPDX-License-Identifier: Apache-2.0
// Version 1.0 of the ABI as it was first published: plugins in the field rely on these places and numbers.
// Structs may grow at the end and enums may be appended to; nothing in these tables may ever change.
#include <gtest/gtest.h>
#include <patina/shader.h>

#include <cstddef>

namespace {

#define AT(type, member, place) EXPECT_EQ(offsetof(type, member), size_t(place)) << #type "." #member

TEST(ShaderAbi, MembersStayWhereTheyAre) {
  AT(PatinaPlane, stride, 8);
  EXPECT_EQ(sizeof(PatinaPlane), 16u);
  EXPECT_EQ(sizeof(PatinaPlane3), 48u);
  EXPECT_EQ(sizeof(PatinaOut3), 24u);
  AT(PatinaParameter, array_length, 12);
  AT(PatinaParameter, name, 16);
  AT(PatinaParameter, unit, 32);
  AT(PatinaParameter, default_floats, 40);
  AT(PatinaParameter, default_strings, 56);
  AT(PatinaParameter, maximum, 72);
  AT(PatinaValue, strings, 16);
  AT(PatinaValue, stride, 24);
  AT(PatinaValue, is_set, 36);
  AT(PatinaPoints, values, 16);
  AT(PatinaPoints, P, 24);
  AT(PatinaPoints, N, 72);
  AT(PatinaPoints, Ng, 120);
  AT(PatinaPoints, dPdu, 168);
  AT(PatinaPoints, u, 264);
  AT(PatinaPoints, s, 296);
  AT(PatinaPoints, footprint, 328);
  AT(PatinaPoints, footprint_st, 344);
  AT(PatinaPoints, Cs, 360);
  AT(PatinaPoints, Os, 408);
  AT(PatinaPoints, time, 456);
  AT(PatinaPoints, I, 472);
  AT(PatinaDisplacementOut, P, 8);
  AT(PatinaDisplacementOut, N, 32);
  AT(PatinaLightIn, task, 12);
  AT(PatinaLightIn, values, 16);
  AT(PatinaLightIn, value_stride, 24);
  AT(PatinaLightIn, P, 32);
  AT(PatinaLightIn, direction, 128);
  AT(PatinaLightIn, u, 176);
  AT(PatinaLightIn, random_x, 208);
  AT(PatinaLightIn, time, 240);
  AT(PatinaLightOut, direction, 8);
  AT(PatinaLightOut, distance, 32);
  AT(PatinaLightOut, radiance, 40);
  AT(PatinaLightOut, pdf, 64);
  AT(PatinaRadiosityOut, emission, 8);
  AT(PatinaRadiosityOut, opacity, 104);
  AT(PatinaLobe, weight, 8);
  AT(PatinaLobe, transmission, 32);
  AT(PatinaLobe, alpha, 56);
  AT(PatinaLobe, eta, 64);
  AT(PatinaViewOut, emission, 8);
  AT(PatinaViewOut, lobes, 32);
  AT(PatinaViewOut, lobe_stride, 40);
  AT(PatinaHost, host, 8);
  AT(PatinaHost, report, 16);
  AT(PatinaHost, open_texture, 32);
  AT(PatinaHost, environment, 48);
  AT(PatinaHost, extension, 64);
  AT(PatinaTraits, reads, 8);
  AT(PatinaTraits, flags, 40);
  AT(PatinaTraits, displacement_bound, 48);
  AT(PatinaTraits, light_power, 56);
  AT(PatinaTraits, light_from, 64);
  AT(PatinaTraits, light_axis, 76);
  AT(PatinaTraits, light_cone, 88);
  AT(PatinaPrepare, host, 8);
  AT(PatinaPrepare, values, 16);
  AT(PatinaPrepare, shader_to_world, 88);
  AT(PatinaShader, name, 8);
  AT(PatinaShader, parameters, 24);
  AT(PatinaShader, parameter_stride, 36);
  AT(PatinaShader, prepare, 40);
  AT(PatinaShader, displacement, 56);
  AT(PatinaShader, view, 80);
}

TEST(ShaderAbi, NumbersStayWhatTheyAre) {
  EXPECT_EQ(PATINA_ABI_MAJOR, 1u);
  EXPECT_EQ(PATINA_LANES, 16u);
  EXPECT_EQ(PATINA_MAX_LOBES, 8u);
  EXPECT_EQ(PATINA_HPOINT, 9);
  EXPECT_EQ(PATINA_LIGHT_AREA, 4);
  EXPECT_EQ(PATINA_LIGHT_EMIT, 3);
  EXPECT_EQ(PATINA_LOBE_DIELECTRIC, 3);
  EXPECT_EQ(PATINA_ENTRY_VIEW, 3);
  EXPECT_EQ(PATINA_CHANNEL_TIME, uint64_t(1) << 11);
  EXPECT_EQ(PATINA_TRAIT_CAMERA_VISIBLE, uint64_t(1) << 7);
  EXPECT_EQ(PATINA_TRAIT_OPACITY_IS_OS, uint64_t(1) << 8);
  EXPECT_EQ(PATINA_TRAIT_TRANSPARENT, uint64_t(1) << 9);
  EXPECT_EQ(PATINA_TRAIT_SMOOTH, uint64_t(1) << 10);
}

}  // namespace
