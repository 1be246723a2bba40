// SPDX-License-Identifier: Apache-2.0
// One call of an entry point: the inputs in guarded planes, and what came out.
#pragma once

#include <array>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "patina/shader.h"
#include "renderer/shadercheck/guarded_memory.h"
#include "renderer/shadercheck/lane.h"

namespace patina::shadercheck {

/// What an entry point may be called for; `light` has three tasks.
enum class Call { Displacement, Radiosity, View, LightSample, LightEvaluate, LightEmit };
inline constexpr Call kAllCalls[] = {Call::Displacement, Call::Radiosity,     Call::View,
                                     Call::LightSample,  Call::LightEvaluate, Call::LightEmit};

std::string_view callName(Call call);  ///< as messages name it: "radiosity", "light (sample)" ...
PatinaEntry entryOf(Call call);
/// Where a value of an Output stands, for messages: "reflectance.x", "lobe 2 alpha" ...
std::string columnName(Call call, uint32_t column);

// Columns of outputs: the first of each; colours and vectors have three.
inline constexpr uint32_t kMovedP = 0, kMovedN = 3;
inline constexpr uint32_t kEmission = 0, kReflectance = 3, kTransmittance = 6, kAmbient = 9, kOpacity = 12;
inline constexpr uint32_t kFirstLobe = 3, kLobeColumns = 8;  // after the emission
inline constexpr uint32_t kLobeWeight = 0, kLobeTransmission = 3, kLobeAlpha = 6, kLobeEta = 7;
inline constexpr uint32_t kFirstLobeData =
    kFirstLobe + kLobeColumns * PATINA_MAX_LOBES;  // where there are any
inline constexpr uint32_t kLightDirection = 0, kLightDistance = 3, kLightRadiance = 4, kLightPdf = 7;

/// The lanes' results, those that the renderer would look at; the others are zero.
struct Output {
  PatinaStatus status = PATINA_OK;
  bool writesNormal = false;
  uint32_t lobeCount = 0, claimedLobes = 0;  ///< at most PATINA_MAX_LOBES; as the shader says
  std::array<uint32_t, PATINA_MAX_LOBES> lobeTypes{};
  uint32_t lanes = 0, columns = 0;
  std::vector<float> values;  ///< lane by lane

  float at(uint32_t lane, uint32_t column) const { return values[size_t(lane) * columns + column]; }
  V3f triple(uint32_t lane, uint32_t column) const {
    return {at(lane, column), at(lane, column + 1), at(lane, column + 2)};
  }
};

/// Where two lanes differ in a bit (any NaN is every other); empty = nowhere.
std::string difference(Call call, const Output& a, uint32_t laneA, const Output& b, uint32_t laneB);

/// How a batch is laid out; by default as the renderer does it.
struct Layout {
  uint64_t channels = 0;          ///< those that are there; the others are NULL
  uint64_t nan = 0, foreign = 0;  ///< those of them that hold NaN, or values of other lanes
  uint64_t padding = 0;           ///< seed of what lanes past the last hold; 0 = they repeat the last
  bool oneForAll = false;         ///< planes of stride 0 with the values of the first lane
  enum { Uniform, Spread, Varying } parameters = Uniform;  ///< Spread: planes that hold the uniform value
};

/// `lobeData`: numbers that custom lobes take of each lobe. [one thread]
class Batch {
 public:
  Batch(const PatinaShader& shader, const PatinaTraits& traits, Call call,
        std::span<const PatinaValue> values, std::span<const Lane> lanes, const Layout& layout,
        uint32_t lobeData = 0);
  Batch(const Batch&) = delete;
  Batch& operator=(const Batch&) = delete;

  /// Outputs as the renderer hands them over.
  void reset();
  PatinaStatus call(void* instance);
  Output output() const;
  /// Whether the outputs are those of `other`, to the bit and with all that the renderer does not look at: a
  /// quick way to see that there is no difference().
  bool hasSamePlanes(const Batch& other) const;
  GuardedMemory::Damage findDamage() const { return memory_.findDamage(); }

 private:
  void fillSurface(const Layout& layout);
  void fillLight(const Layout& layout);
  void fillParameters(const Layout& layout, std::span<const PatinaValue> values);
  void makeOutputs();
  bool isShown(const Output& output, uint32_t column) const;

  template <class Value>
  PatinaPlane plane(const Layout& layout, uint64_t channel, const char* name, Value value);
  template <class Value>
  PatinaPlane3 plane3(const Layout& layout, uint64_t channel, const char* name, Value value);

  const PatinaShader& shader_;
  Call call_;
  uint32_t lightKind_, lobeData_;
  std::vector<Lane> lanes_;  // with the padding
  uint32_t count_, padded_;
  GuardedMemory memory_;
  std::vector<PatinaValue> values_;
  PatinaPoints points_{};
  PatinaLightIn lightIn_{};
  std::vector<float*> columns_;
  PatinaDisplacementOut displaced_{};
  PatinaRadiosityOut radiosity_{};
  PatinaViewOut view_{};
  std::array<PatinaLobe, PATINA_MAX_LOBES> lobes_{};  // their data are the last columns
  PatinaLightOut lightOut_{};
  PatinaStatus status_ = PATINA_OK;
};

}  // namespace patina::shadercheck
