// SPDX-License-Identifier: Apache-2.0
// Which calls of plugins are under way, for who ends a render whose shader does not come back.
//
// A thread that hangs in a plugin cannot be unwound, nor stopped without harm: all that can be done is to say
// where it hangs, to save what is there, and to end the process. So a call that has been found late never
// comes back: its thread stands still where it would, and what it was called with stays as it is.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "renderer/shading/work_place.h"
#include "rib/error.h"

namespace patina {

class ShaderInstance;

/// Says where the points of the calls that the thread makes next are, as long as it lives. `text` is kept by
/// reference, and asked from another thread while a call goes on, if at all: it takes no locks.
class CallPlace {
 public:
  template <class Text>
  explicit CallPlace(const Text& text)
      : object_(&text),
        text_([](const void* object) -> std::string { return (*static_cast<const Text*>(object))(); }) {
    current() = this;
  }
  ~CallPlace() { current() = before_; }
  CallPlace(const CallPlace&) = delete;
  CallPlace& operator=(const CallPlace&) = delete;

  std::string text() const { return text_(object_); }
  static const CallPlace*& current() {
    thread_local const CallPlace* place = nullptr;
    return place;
  }

 private:
  const void* object_;
  std::string (*text_)(const void*);
  const CallPlace* before_ = current();
};

/// Watches over all calls of the process as long as it lives; without one a call costs a test of a flag. One
/// at a time.
class ShaderWatch {
 public:
  ShaderWatch();
  ~ShaderWatch();
  ShaderWatch(const ShaderWatch&) = delete;
  ShaderWatch& operator=(const ShaderWatch&) = delete;

  struct Late {
    std::string shader;
    const char* entry;
    Location where;     ///< the request of the shader
    std::string place;  ///< of its points; "" = not known
    WorkPlace pixels;   ///< that were being made
  };
  /// A call that was already under way `rounds` calls of this ago. Time is counted in rounds so that a
  /// process that was stopped, or a machine that was asleep, makes no call late. [one thread]
  std::optional<Late> findLate(uint32_t rounds);
};

namespace detail {
extern std::atomic<bool> shaderWatch;
}
inline bool watchesShaders() { return detail::shaderWatch.load(std::memory_order_relaxed); }

/// A call under way, of the thread that makes one. `entry` lives as long as the process.
class WatchedCall {
 public:
  WatchedCall(const ShaderInstance& shader, const char* entry);
  ~WatchedCall();  ///< does not return if the call was found late
  WatchedCall(const WatchedCall&) = delete;
  WatchedCall& operator=(const WatchedCall&) = delete;
};

}  // namespace patina
