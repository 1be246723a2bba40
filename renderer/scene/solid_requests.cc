// SPDX-License-Identifier: Apache-2.0
// SolidBegin and SolidEnd: the tree of each solid (RI 3.2 section 5.7).
#include <fmt/format.h>

#include <algorithm>

#include "renderer/scene/scene_builder.h"

namespace patina {
namespace {

constexpr std::string_view kOperations[] = {"primitive", "union", "intersection", "difference"};

std::string_view name(Solid::Operation operation) { return kOperations[static_cast<size_t>(operation)]; }

}  // namespace

void SceneBuilder::solidBegin(std::string_view operation, const Location& at) {
  const auto known = static_cast<size_t>(std::ranges::find(kOperations, operation) - kOperations);
  auto meant = Solid::Operation::Union;  // loses none of its operands
  if (known < std::size(kOperations)) {
    meant = static_cast<Solid::Operation>(known);
  } else {
    error(RiError::BadToken, at,
          fmt::format("SolidBegin \"{}\": expected primitive, union, intersection or difference", operation));
  }
  if (!open(BlockKind::Solid, at)) return;
  if (!inWorld() && !inObject())
    return error(RiError::IllState, at, "SolidBegin outside of WorldBegin and ObjectBegin has no effect");
  SolidPlace& place = state_.solid;
  uint32_t parent = kNone;
  if (place.solid == kNone) {
    place.solid = static_cast<uint32_t>(solids().size());
    place.firstPrimitive = primitives().size();
    solids().emplace_back();
  } else {
    parent = place.node;
    const Solid::Node& outer = solids()[place.solid].nodes[parent];
    if (outer.operation == Solid::Operation::Primitive)
      return error(RiError::BadSolid, at,
                   fmt::format("SolidBegin \"{}\" inside SolidBegin \"primitive\" of {}: its surfaces are "
                               "taken as a part of that one",
                               operation, toString(outer.where)),
                   "solid in a primitive");
  }
  std::vector<Solid::Node>& nodes = solids()[place.solid].nodes;
  place.node = static_cast<uint32_t>(nodes.size());
  nodes.push_back({meant, parent, at});
}

void SceneBuilder::placeInSolid(Primitive& primitive, std::string_view request) {
  const SolidPlace& place = state_.solid;
  std::vector<Solid::Node>& nodes = solids()[place.solid].nodes;
  primitive.solid = place.solid;
  primitive.operand = place.node;
  const Solid::Node& around = nodes[place.node];
  if (around.operation == Solid::Operation::Primitive) return;
  error(
      RiError::BadSolid, primitive.where,
      fmt::format("{} straight inside SolidBegin \"{}\" of {}: expected SolidBegin \"primitive\" around it; "
                  "it is taken as an operand of its own",
                  request, name(around.operation), toString(around.where)),
      "primitive in an operation");
  primitive.operand = static_cast<uint32_t>(nodes.size());
  nodes.push_back({Solid::Operation::Primitive, place.node, primitive.where});
}

/// At the end of a block: when it is the outermost one, the solid is complete.
void SceneBuilder::endSolid() {
  const SolidPlace& place = state_.solid;
  if (place.solid == kNone || savedStates_.back().solid.solid != kNone) return;
  std::vector<Solid::Node>& nodes = solids()[place.solid].nodes;
  const auto forEachPrimitive = [&](auto visit) {
    for (size_t k = place.firstPrimitive; k < primitives().size(); ++k)
      if (primitives()[k].solid == place.solid) visit(primitives()[k]);
  };
  // What has one operand is that operand, and a surface like any other.
  const bool single = std::ranges::count(nodes, Solid::Operation::Primitive, &Solid::Node::operation) <= 1;
  if (!single)
    forEachPrimitive([&](const Primitive& primitive) {
      if (primitive.attributes == kNone || scene_.attributes[primitive.attributes].areaLight == kNone) return;
      // Lights are sampled all over their surfaces.
      warning(RiError::Incapable, primitive.where,
              "an area light inside SolidBegin is no part of the solid: its operand is drawn whole",
              "light in solid");
      nodes[primitive.operand].absent = true;
    });
  forEachPrimitive([&](Primitive& primitive) {
    if (single || nodes[primitive.operand].absent) primitive.solid = kNone;
  });
  if (single) solids().pop_back();
}

}  // namespace patina
