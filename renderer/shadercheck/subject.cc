// SPDX-License-Identifier: Apache-2.0
// Binds shaders, and calls them under supervision.
#include "renderer/shadercheck/subject.h"

#include <fmt/format.h>

namespace patina::shadercheck {

Subject::Subject(const Context& context, const ParameterSet& parameters)
    : context_(context), parameters_(parameters) {
  PatinaPrepare in{};
  in.struct_size = sizeof in;
  in.value_stride = sizeof(PatinaValue);
  in.host = &host_.table();
  in.values = parameters.values().data();
  for (int i = 0; i < 16; i += 5) in.world_to_shader[i] = in.shader_to_world[i] = 1;
  traits_.struct_size = sizeof traits_;
  context_.findings.progress().set("prepare", parameters.name());
  host_.setPreparing(true);
  status_ = context.shader.prepare(&in, &instance_, &traits_);
  host_.setPreparing(false);
  reportComplaints("prepare");
}

Subject::~Subject() {
  context_.findings.progress().set("release", parameters_.name());
  if ((status_ == PATINA_OK || instance_) && context_.shader.release) context_.shader.release(instance_);
}

bool Subject::calls(Call call) const {
  if (!active(entryOf(call))) return false;
  const uint32_t kind = traits_.light_kind;
  switch (call) {
    case Call::LightSample:
      return kind == PATINA_LIGHT_AMBIENT || kind == PATINA_LIGHT_DELTA || kind == PATINA_LIGHT_INFINITE;
    case Call::LightEvaluate:
      return kind == PATINA_LIGHT_INFINITE;
    case Call::LightEmit:
      return kind == PATINA_LIGHT_AREA;
    default:
      return true;
  }
}

std::vector<Call> Subject::calls() const {
  std::vector<Call> all;
  for (const Call call : kAllCalls)
    if (calls(call)) all.push_back(call);
  return all;
}

uint64_t Subject::channels(Call call) const {
  switch (call) {
    case Call::LightSample:
      return PATINA_CHANNEL_P | kChannelRandom | PATINA_CHANNEL_TIME;
    case Call::LightEvaluate:
      return PATINA_CHANNEL_P | kChannelDirection | PATINA_CHANNEL_TIME;
    case Call::LightEmit:
      return kLightChannels & ~kChannelRandom;
    default:
      return traits_.reads[entryOf(call)] & kSurfaceChannels;
  }
}

Output Subject::run(Call call, std::span<const Lane> lanes, const Layout& layout, std::string_view doing) {
  context_.findings.progress().set(
      callName(call), doing.empty() ? parameters_.name() : fmt::format("{}; {}", doing, parameters_.name()));
  const std::unique_ptr<Batch> made = batch(call, lanes, layout);
  if (const PatinaStatus status = made->call(instance_); status != PATINA_OK)
    fault(call, fmt::format("returned the status {} for arguments that make sense", status));
  if (const auto [what, where] = made->findDamage(); !what.empty())
    fault(call, what, fmt::format("a batch of {}{}{}", lanes.size(), where.empty() ? "" : ": ", where));
  reportComplaints(callName(call));
  return made->output();
}

void Subject::fault(std::string_view entry, const std::string& text, const std::string& detail) {
  context_.findings.fault(entry, text,
                          detail.empty() ? parameters_.name() : parameters_.name() + "; " + detail);
}

void Subject::reportComplaints(std::string_view entry) {
  for (const std::string& complaint : host_.takeComplaints()) fault(entry, complaint);
}

void forEachSubject(const Context& context, const std::function<void(Subject&)>& body) {
  for (const ParameterSet& set : context.sets) {
    Subject subject(context, set);
    if (subject.status() == PATINA_OK) body(subject);
  }
}

}  // namespace patina::shadercheck
