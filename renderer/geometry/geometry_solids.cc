// SPDX-License-Identifier: Apache-2.0
// The solids of a scene: which surfaces bound them, and which way those face.
#include <fmt/format.h>

#include <tuple>

#include "renderer/base/statistics.h"
#include "renderer/geometry/geometry.h"

namespace patina {
namespace {

STAT_COUNTER("Solids/solids", solidCount);
STAT_COUNTER("Solids/operands", operandCount);
STAT_COUNTER("Solids/operands that are not closed", openCount);

}  // namespace

void Geometry::makeSolids(const std::vector<Solid>& solids, uint32_t first,
                          std::vector<M44d>* toWorld) const {
  if (solids.empty()) return;
  const size_t firstOfWorld = toWorld ? traced_.size() - toWorld->size() : 0;
  // The surfaces of each leaf, in their order.
  std::vector<uint32_t> members;
  for (uint32_t k = first; k < traced_.size(); ++k)
    if (traced_[k].primitive->solid != kNone) members.push_back(k);
  const auto leafOf = [&](uint32_t k) {
    return std::tie(traced_[k].primitive->solid, traced_[k].primitive->operand);
  };
  std::stable_sort(members.begin(), members.end(),
                   [&](uint32_t a, uint32_t b) { return leafOf(a) < leafOf(b); });

  std::vector<bool> removed(traced_.size() - first, false);
  size_t next = 0;
  for (uint32_t index = 0; index < solids.size(); ++index) {
    const Solid& solid = solids[index];
    std::vector<LeafContent> content(solid.nodes.size(), LeafContent::Empty);
    std::vector<SolidTree::Rule> rules(solid.nodes.size());
    const size_t begin = next;
    std::vector<bool> turned;
    while (next < members.size() && traced_[members[next]].primitive->solid == index) {
      const uint32_t leaf = traced_[members[next]].primitive->operand;
      std::vector<LeafSurface> surfaces;
      for (; next < members.size() && leafOf(members[next]) == std::tie(index, leaf); ++next) {
        const TracedSurface& traced = traced_[members[next]];
        surfaces.push_back({made_[members[next]].get(), traced.toMesh, traced.isReversed});
      }
      const LeafReport report = examineLeaf(surfaces);
      content[leaf] = report.closed ? LeafContent::Closed : LeafContent::Open;
      rules[leaf] = report.rule;
      turned.insert(turned.end(), report.turned.begin(), report.turned.end());
      ++operandCount;
      if (report.closed) continue;
      ++openCount;
      errors_.report(Severity::Warning, RiError::BadSolid, solid.nodes[leaf].where,
                     "the surfaces of this operand of a solid are not closed: they are drawn whole",
                     "open solid");
    }
    PrunedSolid pruned = pruneSolid(solid, content);
    if (pruned.emptied)
      errors_.report(
          Severity::Warning, RiError::BadSolid, solid.nodes[0].where,
          "operands of this solid are left out: what they would be intersected with, or taken from, "
          "has no surfaces or none that are closed",
          "empty solid");
    for (size_t k = begin; k < next; ++k) {
      TracedSurface& traced = traced_[members[k]];
      const uint32_t leaf = traced.primitive->operand;
      if (pruned.fates[leaf] == PrunedSolid::Fate::Removed) removed[members[k] - first] = true;
      if (pruned.fates[leaf] != PrunedSolid::Fate::Kept) continue;
      SolidTree::Node& node = pruned.tree.nodes[pruned.leaf[leaf]];
      node.rule = rules[leaf];
      traced.solid = static_cast<uint32_t>(solids_.size());
      traced.leaf = pruned.leaf[leaf];
      traced.isTurned = turned[k - begin] != node.subtracted;
      const bool intoLeaf = traced.isReversed != turned[k - begin];
      traced.leafSign = (M44d(traced.toMesh).determinant() < 0) != intoLeaf ? -1.0f : 1.0f;
    }
    if (pruned.tree.nodes.empty()) continue;
    ++solidCount;
    solids_.push_back(std::move(pruned.tree));
  }

  // What is no part of any result is not there.
  uint32_t kept = first;
  for (uint32_t k = first; k < traced_.size(); ++k) {
    if (removed[k - first]) continue;
    if (kept != k) {
      traced_[kept] = traced_[k], made_[kept] = std::move(made_[k]);
      if (toWorld) (*toWorld)[kept - firstOfWorld] = (*toWorld)[k - firstOfWorld];
    }
    ++kept;
  }
  traced_.shrinkTo(kept);
  made_.shrinkTo(kept);
  if (toWorld) toWorld->resize(kept - firstOfWorld);
}

}  // namespace patina
