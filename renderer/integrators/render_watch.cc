// SPDX-License-Identifier: Apache-2.0
// Rounds of a watch.
#include "renderer/integrators/render_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>

namespace patina {
namespace {

constexpr double kLongestRound = 0.25;  // seconds
constexpr double kRoundsInLimit = 4;    // of a limit for shaders, at least

}  // namespace

RenderWatch::RenderWatch(const RenderSettings& settings, const Film& film)
    : settings_(settings), film_(film) {
  if (!settings.abandon) return;
  if (settings.shaderSeconds > 0) shaders_.emplace();
  if (shaders_ || settings.interrupted) thread_ = std::thread([this] { watch(); });
}

RenderWatch::~RenderWatch() { bucketsEnded(); }

void RenderWatch::bucketsEnded() {
  if (!thread_.joinable()) return;
  {
    const std::scoped_lock lock(mutex_);
    isEnded_ = true;
  }
  ended_.notify_all();
  thread_.join();
}

void RenderWatch::watch() {
  const double limit = settings_.shaderSeconds;
  const double round = shaders_ ? std::min(kLongestRound, limit / kRoundsInLimit) : kLongestRound;
  const auto roundsOf = [&](double seconds) {
    return static_cast<uint32_t>(std::min(std::ceil(seconds / round), 1e9));
  };
  uint32_t sinceInterruption = 0;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      if (ended_.wait_for(lock, std::chrono::duration<double>(round), [&] { return isEnded_; })) return;
    }
    if (shaders_)
      if (const auto late = shaders_->findLate(roundsOf(limit))) {
        std::string text = fmt::format("shader \"{}\": {} has not returned within {:g} seconds", late->shader,
                                       late->entry, limit);
        if (!late->place.empty()) text += ". The first of its points is at " + late->place;
        if (const WorkPlace& p = late->pixels; !p.empty())
          text +=
              fmt::format("; pixels {} to {} by {} to {} were being made", p.x0, p.x1 - 1, p.y0, p.y1 - 1);
        abandon(text, late->where);
      }
    if (settings_.interrupted && settings_.interrupted() &&
        ++sinceInterruption > roundsOf(settings_.graceSeconds))
      abandon(fmt::format("what was in work has not ended within {:g} seconds of the interruption",
                          settings_.graceSeconds),
              {});
  }
}

void RenderWatch::abandon(const std::string& why, const Location& where) const {
  const std::unique_ptr<const Film> film = film_.snapshot();
  settings_.abandon({why, where, film->sampleCount() > 0 ? film.get() : nullptr});
  std::_Exit(1);
}

}  // namespace patina
