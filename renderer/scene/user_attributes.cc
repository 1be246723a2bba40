// SPDX-License-Identifier: Apache-2.0
// Values of Attribute "user", kept in the order of their names.
#include <algorithm>

#include "renderer/scene/hash.h"
#include "renderer/scene/scene.h"

namespace patina {
namespace {

bool sameValue(const ShaderArgument& a, const ShaderArgument& b) {
  return a.name == b.name && a.type == b.type && a.arrayLength == b.arrayLength && a.floats == b.floats &&
         a.ints == b.ints && a.strings == b.strings;
}

}  // namespace

const ShaderArgument* UserAttributes::find(std::string_view name) const {
  if (!all_) return nullptr;
  const auto found = std::ranges::lower_bound(all_->byName, name, {},
                                              [](const auto& a) -> std::string_view { return a->name; });
  return found != all_->byName.end() && (*found)->name == name ? found->get() : nullptr;
}

bool UserAttributes::set(ShaderArgument attribute) {
  if (const ShaderArgument* known = find(attribute.name); known && sameValue(*known, attribute)) return true;
  auto all = std::make_shared<All>(all_ ? *all_ : All());
  const auto place = std::ranges::lower_bound(all->byName, attribute.name, {},
                                              [](const auto& a) -> const std::string& { return a->name; });
  const bool isNew = place == all->byName.end() || (*place)->name != attribute.name;
  if (isNew && all->byName.size() == kMost) return false;
  auto value = std::make_shared<const ShaderArgument>(std::move(attribute));
  if (isNew)
    all->byName.insert(place, std::move(value));
  else
    *place = std::move(value);
  Hasher hasher;
  for (const auto& a : all->byName) {
    hasher.add(a->name).add(a->type).add(a->arrayLength).add(a->floats).add(a->ints);
    for (const std::string& text : a->strings) hasher.add(text);
  }
  all->hash = hasher.value();
  all_ = std::move(all);
  return true;
}

bool UserAttributes::operator==(const UserAttributes& other) const {
  if (all_ == other.all_) return true;
  if (!all_ || !other.all_ || all_->hash != other.all_->hash) return false;
  return std::ranges::equal(all_->byName, other.all_->byName,
                            [](const auto& a, const auto& b) { return a == b || sameValue(*a, *b); });
}

}  // namespace patina
