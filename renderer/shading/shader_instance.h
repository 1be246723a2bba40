// SPDX-License-Identifier: Apache-2.0
// A shader bound to the values of one request: checked arguments in world space, traits, and its four entry
// points.
#pragma once

#include <array>
#include <deque>
#include <exception>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "patina/shader.h"
#include "renderer/scene/scene.h"
#include "renderer/shading/custom_lobe.h"
#include "renderer/shading/shader_host.h"
#include "renderer/shading/shader_watch.h"

namespace patina {

/// Made on one thread, then immutable: the entry points may be called from any thread, several at a time.
class ShaderInstance {
 public:
  /// A parameter that a primitive variable of the same name and type replaces, batch by batch.
  struct VaryingParameter {
    uint32_t index;  ///< of values() and of the shader's table
    std::string_view name;
    uint32_t type;          ///< PatinaType; never PATINA_STRING or PATINA_INT
    uint32_t components;    ///< of the type times the array length
    std::string attribute;  ///< the user attribute that takes its place where there is no variable; "" = none
  };

  /// Binds and prepares. Arguments that do not fit are reported to `errors` and keep their defaults. nullptr:
  /// the shader's `prepare` failed or its traits make no sense, which has been reported as an error.
  static std::unique_ptr<ShaderInstance> create(const PatinaShader& shader, const ShaderBinding& binding,
                                                ShaderHost& host, ErrorHandler& errors);
  ~ShaderInstance();
  ShaderInstance(const ShaderInstance&) = delete;
  ShaderInstance& operator=(const ShaderInstance&) = delete;

  const PatinaShader& shader() const { return shader_; }
  std::string_view name() const { return shader_.name; }
  const Location& where() const { return where_; }  ///< of the request

  const PatinaTraits& traits() const { return traits_; }
  bool active(PatinaEntry entry) const { return (traits_.active >> entry & 1u) != 0; }
  bool has(uint64_t flag) const { return (traits_.flags & flag) != 0; }
  uint64_t reads(PatinaEntry entry) const { return active(entry) ? traits_.reads[entry] : 0; }
  /// Channels of a surface that any of the active surface entry points reads.
  uint64_t surfaceReads() const { return reads(PATINA_ENTRY_RADIOSITY) | reads(PATINA_ENTRY_VIEW); }

  /// One value per parameter in the order of the table, all uniform: what a batch passes, with the varying
  /// ones replaced where a primitive has the variable.
  std::span<const PatinaValue> values() const { return values_; }
  std::span<const VaryingParameter> varyingParameters() const { return varying_; }

  // The entry points. What a plugin throws goes no further: it is a status, and a message as every status but
  // PATINA_OK is.
  PatinaStatus displacement(const PatinaPoints& in, PatinaDisplacementOut& out) const {
    return run("displacement", [&] { return shader_.displacement(data_, &in, &out); });
  }
  PatinaStatus light(const PatinaLightIn& in, PatinaLightOut& out) const {
    return run("light", [&] { return shader_.light(data_, &in, &out); });
  }
  PatinaStatus radiosity(const PatinaPoints& in, PatinaRadiosityOut& out) const {
    return run("radiosity", [&] { return shader_.radiosity(data_, &in, &out); });
  }
  PatinaStatus view(const PatinaPoints& in, PatinaViewOut& out) const {
    return run("view", [&] { return shader_.view(data_, &in, &out); });
  }

  /// Of a shader for Atmosphere: see PATINA_EXTENSION_ATMOSPHERE.
  bool hasAtmosphere() const { return atmosphere_ != nullptr; }
  PatinaStatus atmosphere(const PatinaAtmosphereIn& in, PatinaAtmosphereOut& out) const {
    return run("atmosphere", [&] { return atmosphere_(data_, &in, &out); });
  }
  /// The lobe that `view` calls `type`, one of its own; nullptr = there is none.
  const CustomLobe* customLobe(uint32_t type) const {
    const size_t k = size_t(type) - PATINA_LOBE_CUSTOM;
    return type >= PATINA_LOBE_CUSTOM && k < customLobes_.size() ? &customLobes_[k] : nullptr;
  }
  bool hasCustomLobes() const { return !customLobes_.empty(); }
  uint32_t lobeDataCount() const { return lobeDataCount_; }  ///< numbers that its lobes take at most
  /// Rays that an entry point traces for one point at most: see RayCall.
  uint32_t raysOf(PatinaEntry entry) const { return rays_[entry]; }
  const Accel* accel() const { return host_.accel(); }
  /// `prepare` asked for user attributes of the request: another request's may make another instance.
  bool readsUserAttributes() const { return readsUserAttributes_; }
  /// Some parameter is to take its value from user attributes of primitives.
  bool bindsUserAttributes() const { return bindsUserAttributes_; }
  /// Calls a function of one of its lobes, of which `entry` is the name, with what `prepare` wrote.
  template <class Function, class In, class Out>
  PatinaStatus lobe(const char* entry, Function function, const In& in, Out& out) const {
    return run(entry, [&] { return function(data_, &in, &out); });
  }

  /// Counts points whose results cannot be used: see ShaderHost::fault(). [any thread]
  void fault(ShaderHost::Fault fault, uint64_t points, const V3f& at,
             const std::function<std::string()>& describe) const {
    host_.fault(name(), where_, fault, points, at, describe);
  }

  /// What the plugin calls back; also where callers report what they found wrong with its results.
  const PatinaHost& host() const { return table_; }

 private:
  ShaderInstance(const PatinaShader& shader, const ShaderBinding& binding, ShaderHost& host);

  struct Services;

  /// Calls a function of the plugin: watched over, where somebody watches, and with what it throws caught.
  template <class Call>
  PatinaStatus run(const char* entry, const Call& call) const {
    try {
      std::optional<WatchedCall> watched;
      if (watchesShaders()) watched.emplace(*this, entry);
      const PatinaStatus status = call();
      if (status != PATINA_OK) [[unlikely]]
        reportFailure(entry, status, nullptr);
      return status;
    } catch (const std::exception& thrown) {
      reportFailure(entry, PATINA_ERROR_INTERNAL, thrown.what());
    } catch (...) {
      reportFailure(entry, PATINA_ERROR_INTERNAL, "which is no std::exception");
    }
    return PATINA_ERROR_INTERNAL;
  }
  /// Counts a call that failed, or threw what says `thrown`. [any thread]
  void reportFailure(const char* entry, PatinaStatus status, const char* thrown) const;

  void setDefaults();
  void finishValues();
  bool prepare(ErrorHandler& errors);

  const PatinaShader& shader_;
  Location where_;
  M44d shaderToWorld_, worldToShader_;
  ShaderHost& host_;
  UserAttributes user_;  // of the request
  PatinaHost table_{};

  std::vector<PatinaValue> values_;
  std::vector<std::vector<float>> floats_;  // by parameter
  std::vector<std::vector<int32_t>> ints_;
  std::vector<std::vector<std::string>> strings_;
  std::vector<std::vector<const char*>> pointers_;
  std::vector<VaryingParameter> varying_;

  std::vector<CustomLobe> customLobes_;
  uint32_t lobeDataCount_ = 0;
  std::array<uint32_t, PATINA_ENTRIES> rays_{};             // by PatinaEntry
  std::string refusal_;                                     // why a lobe or rays were refused
  std::deque<std::vector<const char*>> attributePointers_;  // texts handed out
  bool readsUserAttributes_ = false, bindsUserAttributes_ = false;

  PatinaTraits traits_{};
  PatinaAtmosphereFunction atmosphere_ = nullptr;
  void* data_ = nullptr;
  bool prepared_ = false;
};

/// What in traits makes no sense, as the rest of a sentence; empty = nothing.
std::string findTraitsFault(const PatinaTraits& traits);

}  // namespace patina
