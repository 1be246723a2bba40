// SPDX-License-Identifier: Apache-2.0
// What one lane of a batch is given, by every entry point's channels, and lanes to try shaders on.
#pragma once

#include <string>
#include <vector>

#include "patina/shader.h"
#include "renderer/base/math.h"

namespace patina::shadercheck {

/// The inputs of lights that no PATINA_CHANNEL_ bit stands for.
inline constexpr uint64_t kChannelDirection = uint64_t{1} << 62;
inline constexpr uint64_t kChannelRandom = uint64_t{1} << 63;
inline constexpr uint64_t kSurfaceChannels = (PATINA_CHANNEL_DPDT << 1) - 1;
inline constexpr uint64_t kLightChannels = PATINA_CHANNEL_P | PATINA_CHANNEL_N | PATINA_CHANNEL_UV |
                                           PATINA_CHANNEL_TIME | kChannelDirection | kChannelRandom;

/// "P", "s and t" ..., by a single bit.
std::string_view channelName(uint64_t channel);
/// Of several bits, separated by commas.
std::string channelNames(uint64_t channels);

struct Lane {
  uint64_t id = 0;  ///< what the lane's varying parameters are drawn with
  V3f P, N, Ng, dPdu, dPdv, dPds, dPdt;
  float u, v, s, t, footprint, footprintSt;
  V3f Cs, Os;
  float time;
  V3f I;
  V3f direction;  ///< of lights
  float randomX, randomY;
};

/// Lanes as an ordinary scene has them: a few units large, colours and opacities in [0, 1]. The same seed
/// gives the same lanes.
std::vector<Lane> makeLanes(uint32_t count, uint64_t seed);

/// Lanes that keep what the ABI promises (unit normals, colours in [0, 1]) but nothing more: footprints of
/// zero and without end, coordinates as large as the renderer lets them be, derivatives that vanish, grazing
/// views.
std::vector<Lane> makeHostileLanes(uint32_t count, uint64_t seed);

}  // namespace patina::shadercheck
