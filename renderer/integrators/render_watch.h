// SPDX-License-Identifier: Apache-2.0
// Ends renders that cannot end by themselves: a shader that does not come back, buckets that go on and on
// after an interruption.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <thread>

#include "renderer/film/film.h"
#include "renderer/integrators/render.h"
#include "renderer/shading/shader_watch.h"

namespace patina {

/// Watches, from a thread of its own, for what RenderSettings::abandon is for; does nothing where that is not
/// set. [main makes it, and destroys it when all threads have come back]
class RenderWatch {
 public:
  RenderWatch(const RenderSettings& settings, const Film& film);
  ~RenderWatch();
  RenderWatch(const RenderWatch&) = delete;
  RenderWatch& operator=(const RenderWatch&) = delete;

  /// All buckets have ended: what is still to be done may take its time. [main]
  void bucketsEnded();

 private:
  void watch();
  [[noreturn]] void abandon(const std::string& why, const Location& where) const;

  const RenderSettings& settings_;
  const Film& film_;
  std::optional<ShaderWatch> shaders_;
  std::mutex mutex_;
  std::condition_variable ended_;
  bool isEnded_ = false;
  std::thread thread_;  // the last: what it uses is there
};

}  // namespace patina
