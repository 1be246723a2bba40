// SPDX-License-Identifier: Apache-2.0
// A shader bound to a set of parameters, to be called by checks.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "renderer/shadercheck/batch.h"
#include "renderer/shadercheck/check_host.h"
#include "renderer/shadercheck/findings.h"
#include "renderer/shadercheck/parameter_set.h"

namespace patina::shadercheck {

/// What a check works on.
struct Context {
  const PatinaShader& shader;
  const std::vector<ParameterSet>& sets;
  Findings& findings;
};

class Subject {
 public:
  Subject(const Context& context, const ParameterSet& parameters);
  ~Subject();
  Subject(const Subject&) = delete;
  Subject& operator=(const Subject&) = delete;

  PatinaStatus status() const { return status_; }  ///< of prepare
  const PatinaTraits& traits() const { return traits_; }
  bool active(PatinaEntry entry) const { return (traits_.active >> entry & 1u) != 0; }
  bool has(uint64_t flag) const { return (traits_.flags & flag) != 0; }
  /// What the renderer would call: of lights the tasks of their kind.
  bool calls(Call call) const;
  std::vector<Call> calls() const;

  /// The channels that the renderer hands to a call because it reads them, or that its task has.
  uint64_t channels(Call call) const;
  Layout layout(Call call) const { return {channels(call), 0, 0, 0, false, Layout::Uniform}; }

  std::unique_ptr<Batch> batch(Call call, std::span<const Lane> lanes, const Layout& layout) const {
    return std::make_unique<Batch>(context_.shader, traits_, call, parameters_.values(), lanes, layout,
                                   host_.lobeData());
  }
  /// Calls, and reports what may never happen: a bad status, memory written to that is none of the call's,
  /// wrong use of the host. `doing` is for the message should the call not return.
  Output run(Call call, std::span<const Lane> lanes, const Layout& layout, std::string_view doing = {});
  Output run(Call call, std::span<const Lane> lanes) { return run(call, lanes, layout(call)); }

  void* instance() const { return instance_; }
  /// The custom lobes that `prepare` registered.
  const std::vector<const PatinaCustomLobe*>& customLobes() const { return host_.lobes(); }
  const std::string& parametersName() const { return parameters_.name(); }
  /// The function for RI's Atmosphere that `prepare` handed over; nullptr = none.
  PatinaAtmosphereFunction atmosphere() const { return host_.atmosphere(); }
  /// With the parameters in the detail.
  void fault(std::string_view entry, const std::string& text, const std::string& detail = {});
  void fault(Call call, const std::string& text, const std::string& detail = {}) {
    fault(callName(call), text, detail);
  }
  void reportComplaints(std::string_view entry);

 private:
  const Context& context_;
  const ParameterSet& parameters_;
  CheckHost host_;
  PatinaTraits traits_{};
  void* instance_ = nullptr;
  PatinaStatus status_ = PATINA_OK;
};

/// For each set of parameters that the shader can be prepared with.
void forEachSubject(const Context& context, const std::function<void(Subject&)>& body);

}  // namespace patina::shadercheck
