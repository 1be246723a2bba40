// SPDX-License-Identifier: Apache-2.0
// Builds scenes from short RIB texts and keeps what they say.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "renderer/scene/scene_builder.h"

namespace patina {

struct Built {
  std::vector<Scene> worlds;
  std::vector<std::string> messages;
  int status = 0;

  const Scene& world() const { return worlds.at(0); }
  const Attributes& attributesOf(size_t primitive) const {
    return world().attributes.at(world().primitives.at(primitive).attributes);
  }
};

/// Reads `text` as the file t.rib.
inline Built build(std::string_view text, SceneBuilderSettings settings = {}) {
  Built built;
  ErrorHandler errors([&](Severity, std::string_view message) { built.messages.emplace_back(message); });
  SceneBuilder builder(std::move(settings), errors, [&](Scene& scene) { built.worlds.push_back(scene); });
  builder.readText(text, "t.rib");
  built.status = errors.exitStatus();
  return built;
}

/// As build(), for a text in which nothing is wrong and that has one world.
inline Built buildClean(std::string_view text) {
  Built built = build(text);
  EXPECT_THAT(built.messages, testing::IsEmpty());
  EXPECT_EQ(built.worlds.size(), 1u);
  if (built.worlds.empty()) built.worlds.emplace_back();
  return built;
}

inline void expectMatrix(const M44d& actual, const M44d& expected, double tolerance = 1e-12) {
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      EXPECT_NEAR(actual[row][column], expected[row][column], tolerance)
          << "row " << row << " column " << column;
    }
  }
}

}  // namespace patina
