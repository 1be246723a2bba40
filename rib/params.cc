// SPDX-License-Identifier: Apache-2.0
// Look-ups in parameter lists, their deep copies, and reports of what nobody read.
#include "rib/params.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace patina {

const Param* ParamList::find(std::string_view name) const {
  for (auto it = params_.rbegin(); it != params_.rend(); ++it) {
    if (it->declaration.name != name) continue;
    it->used = true;
    return &*it;
  }
  return nullptr;
}

const Param* ParamList::find(std::string_view name, ValueType type) const {
  for (auto it = params_.rbegin(); it != params_.rend(); ++it) {
    if (it->declaration.name != name || it->declaration.type != type) continue;
    it->used = true;
    return &*it;
  }
  return nullptr;
}

float ParamList::floatValue(std::string_view name, float fallback) const {
  for (auto it = params_.rbegin(); it != params_.rend(); ++it) {
    if (it->declaration.name != name || (it->floats.empty() && it->ints.empty())) continue;
    it->used = true;
    return it->floats.empty() ? static_cast<float>(it->ints[0]) : it->floats[0];
  }
  return fallback;
}

int ParamList::intValue(std::string_view name, int fallback) const {
  for (auto it = params_.rbegin(); it != params_.rend(); ++it) {
    if (it->declaration.name != name) continue;
    if (!it->ints.empty()) return it->used = true, it->ints[0];
    if (it->floats.empty()) continue;
    const float value = it->floats[0];
    if (std::abs(value) >= 2147483648.0f || value != std::trunc(value)) continue;
    it->used = true;
    return static_cast<int>(value);
  }
  return fallback;
}

std::string_view ParamList::stringValue(std::string_view name, std::string_view fallback) const {
  for (auto it = params_.rbegin(); it != params_.rend(); ++it) {
    if (it->declaration.name != name || it->strings.empty()) continue;
    it->used = true;
    return it->strings[0];
  }
  return fallback;
}

std::array<float, 3> ParamList::tripleValue(std::string_view name, std::array<float, 3> fallback) const {
  for (auto it = params_.rbegin(); it != params_.rend(); ++it) {
    const auto values = it->floats;
    if (it->declaration.name != name || (values.size() != 1 && values.size() < 3)) continue;
    it->used = true;
    return values.size() == 1 ? std::array{values[0], values[0], values[0]}
                              : std::array{values[0], values[1], values[2]};
  }
  return fallback;
}

void ParamList::reportUnread(ErrorHandler& errors, std::string_view request,
                             std::span<const std::string_view> known) const {
  for (const Param& param : params_) {
    if (param.used) continue;
    const std::string_view near = nearestName(param.name(), known);
    const std::string hint = near.empty() ? std::string() : fmt::format(" (did you mean \"{}\"?)", near);
    errors.reportOnce(Severity::Warning, RiError::BadToken, param.location,
                      fmt::format("unread {} {}", request, param.name()),
                      fmt::format("{}: parameter \"{}\" is not used{}", request, param.name(), hint));
  }
}

OwnedParamList::OwnedParamList(const ParamList& source) {
  if (source.empty()) return;
  auto storage = std::make_shared<Storage>();

  // Make room for everything first, so that the views stay valid while they are made.
  size_t floats = 0, ints = 0, strings = 0, text = 0;
  for (const Param& param : source) {
    floats += param.floats.size();
    ints += param.ints.size();
    strings += param.strings.size();
    text += param.name().size();
    for (std::string_view s : param.strings) text += s.size();
  }
  storage->params.reserve(source.size());
  storage->floats.reserve(floats);
  storage->ints.reserve(ints);
  storage->strings.reserve(strings);
  storage->text.reserve(text);

  const auto keepText = [&](std::string_view s) {
    const size_t start = storage->text.size();
    storage->text += s;
    return std::string_view(storage->text.data() + start, s.size());
  };
  const auto keep = [](auto& pool, auto values) {
    const size_t start = pool.size();
    pool.insert(pool.end(), values.begin(), values.end());
    return decltype(values)(pool.data() + start, values.size());
  };
  for (Param param : source) {
    param.declaration.name = keepText(param.name());
    param.floats = keep(storage->floats, param.floats);
    param.ints = keep(storage->ints, param.ints);
    const size_t start = storage->strings.size();
    for (std::string_view s : param.strings) storage->strings.push_back(keepText(s));
    param.strings = {storage->strings.data() + start, param.strings.size()};
    param.used = false;
    storage->params.push_back(param);
  }
  storage_ = std::move(storage);
}

}  // namespace patina
