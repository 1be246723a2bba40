// SPDX-License-Identifier: Apache-2.0
// What the renderer does for its plugins: coordinate systems, textures, and messages that are counted, not
// printed.
#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>

#include "patina/shader.h"
#include "renderer/base/math.h"
#include "rib/error.h"

namespace patina {

class Accel;
class TextureService;

/// One per frame; must outlive the instances that were made with it. [any thread]
class ShaderHost {
 public:
  /// The matrix from a named coordinate system ("camera", "screen" ... or one of CoordinateSystem) to world
  /// space; empty = not known. "world", "current" and "shader" are not asked for.
  using FindSpace = std::function<std::optional<M44d>(std::string_view name)>;

  /// `textures` may be nullptr: then there are none.
  ShaderHost(FindSpace findSpace, TextureService* textures)
      : findSpace_(std::move(findSpace)), textures_(textures) {}

  /// Counts a message of a shader; the first of each (shader, severity, code) keeps its text and location.
  void report(std::string_view shader, const Location& where, PatinaReport severity, int32_t code,
              std::string_view message);

  /// Codes of what the host finds wrong with a shader's results; a shader's own are what it likes.
  enum Fault : int32_t {
    kBadValues = -1,
    kBadView = -2,
    kBadDisplacement = -3,
    kBadLight = -4,
    kBadLobe = -5
  };
  /// Counts points for which a shader gave what cannot be used. `describe` says of the first of each (shader,
  /// fault) what was given and where; `at` is its place in the world.
  void fault(std::string_view shader, const Location& where, Fault fault, uint64_t points, const V3f& at,
             const std::function<std::string()>& describe);
  /// Says, at the end of such a message, which pixels were made meanwhile and how that is done again. [main]
  void setReplay(std::function<std::string(const V3f& at)> replay) { replay_ = std::move(replay); }

  /// Hands every message that came since the last call to `errors`, once, with its count.
  void summarize(ErrorHandler& errors);

  std::optional<M44d> spaceToWorld(std::string_view name, const M44d& shaderToWorld) const;
  TextureService* textures() const { return textures_; }
  /// What rays of shaders are traced against; without it they meet nothing. Before any is traced. [main]
  void setAccel(const Accel* accel) { accel_ = accel; }
  const Accel* accel() const { return accel_; }

 private:
  struct Entry {
    uint64_t count = 0;
    std::string message;
    Location where;
  };

  FindSpace findSpace_;
  std::function<std::string(const V3f& at)> replay_;
  TextureService* textures_;
  const Accel* accel_ = nullptr;
  std::mutex mutex_;
  std::map<std::tuple<std::string, PatinaReport, int32_t>, Entry> reports_;
};

}  // namespace patina
