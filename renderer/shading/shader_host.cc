// SPDX-License-Identifier: Apache-2.0
// Named coordinate systems for plugins, and the count of what they had to say.
#include "renderer/shading/shader_host.h"

#include <fmt/format.h>

namespace patina {

void ShaderHost::report(std::string_view shader, const Location& where, PatinaReport severity, int32_t code,
                        std::string_view message) {
  const std::lock_guard lock(mutex_);
  Entry& entry = reports_[{std::string(shader), severity, code}];
  if (entry.count++ > 0) return;
  entry.message = message;
  entry.where = where;
}

void ShaderHost::fault(std::string_view shader, const Location& where, Fault fault, uint64_t points,
                       const V3f& at, const std::function<std::string()>& describe) {
  Entry* entry = nullptr;
  {
    const std::lock_guard lock(mutex_);
    entry = &reports_[{std::string(shader), PATINA_REPORT_WARNING, fault}];
    const bool isFirst = entry->count == 0;
    entry->count += points;
    if (!isFirst) return;
  }
  // Without the lock, as the description may need geometry whose making runs shaders.
  std::string message = describe();
  if (replay_) message += replay_(at);
  const std::lock_guard lock(mutex_);
  entry->message = std::move(message);
  entry->where = where;
}

void ShaderHost::summarize(ErrorHandler& errors) {
  decltype(reports_) reports;
  {
    const std::lock_guard lock(mutex_);
    reports.swap(reports_);
  }
  for (const auto& [key, entry] : reports) {
    const auto& [shader, severity, code] = key;
    std::string text = fmt::format("shader \"{}\" (code {}): {}", shader, code, entry.message);
    if (entry.count > 1) text += fmt::format(" [{} times]", entry.count);
    errors.report(severity == PATINA_REPORT_ERROR     ? Severity::Error
                  : severity == PATINA_REPORT_WARNING ? Severity::Warning
                                                      : Severity::Info,
                  RiError::System, entry.where, text);
  }
}

std::optional<M44d> ShaderHost::spaceToWorld(std::string_view name, const M44d& shaderToWorld) const {
  if (name == "current") return M44d();
  if (name == "world") return (findSpace_ ? findSpace_(name) : std::nullopt).value_or(M44d());
  if (name == "shader" || name == "object") return shaderToWorld;
  return findSpace_ ? findSpace_(name) : std::nullopt;
}

}  // namespace patina
