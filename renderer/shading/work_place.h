// SPDX-License-Identifier: Apache-2.0
// What a thread is making, for messages about what goes wrong meanwhile.
#pragma once

namespace patina {

/// Pixels [x0, x1) x [y0, y1) that the calling thread makes; empty: none. Whoever begins a tile says so; work
/// that a thread does for others in between counts as the tile's.
struct WorkPlace {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool empty() const { return x0 >= x1 || y0 >= y1; }

  static WorkPlace& current() {
    thread_local WorkPlace place;
    return place;
  }
};

/// Sets the current place for as long as it lives.
class WorkPlaceScope {
 public:
  explicit WorkPlaceScope(const WorkPlace& place) : before_(WorkPlace::current()) {
    WorkPlace::current() = place;
  }
  ~WorkPlaceScope() { WorkPlace::current() = before_; }
  WorkPlaceScope(const WorkPlaceScope&) = delete;
  WorkPlaceScope& operator=(const WorkPlaceScope&) = delete;

 private:
  WorkPlace before_;
};

}  // namespace patina
