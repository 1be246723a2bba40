// SPDX-License-Identifier: Apache-2.0
// A host that serves plugins with textures made of formulas, and takes down what they ask for wrongly.
#pragma once

#include <array>
#include <atomic>
#include <initializer_list>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "patina/shader.h"
#include "renderer/shadercheck/lane.h"

namespace patina::shadercheck {

/// What the calling thread has called an entry point for, as long as it lives: whose rays are traced.
class HostCall {
 public:
  HostCall(PatinaEntry entry, std::span<const Lane> lanes);
  ~HostCall();
  HostCall(const HostCall&) = delete;
  HostCall& operator=(const HostCall&) = delete;

  const PatinaEntry entry;
  const std::span<const Lane> lanes;
  std::vector<uint32_t> rays;  ///< so far, by lane
};

/// Every name but "" is a texture; the same one. Rays meet a ball of radius 3 about the origin. There are no
/// files and no user attributes. [any thread]
class CheckHost {
 public:
  CheckHost();
  CheckHost(const CheckHost&) = delete;
  CheckHost& operator=(const CheckHost&) = delete;

  const PatinaHost& table() const { return table_; }

  /// Whether `prepare` runs, which alone may call what is [main].
  void setPreparing(bool preparing) { preparing_ = preparing; }
  /// What `prepare` registered, in its order.
  const std::vector<const PatinaCustomLobe*>& lobes() const { return lobes_; }
  uint32_t lobeData() const;                                           ///< numbers that they take at most
  PatinaAtmosphereFunction atmosphere() const { return atmosphere_; }  ///< nullptr = none
  /// What `prepare` declared, by PatinaEntry.
  uint32_t raysOf(PatinaEntry entry) const { return rays_[entry]; }
  /// What was wrong with calls since the last time: "gave texture() ...".
  std::vector<std::string> takeComplaints();

 private:
  struct Services;
  PatinaTexture* texture();
  void complain(std::string text);
  void checkPreparing(const char* service);
  // Whether the look-up can be made at all.
  bool checkLookup(const char* service, const PatinaTexture* texture, uint32_t count,
                   std::initializer_list<PatinaPlane> planes, const PatinaOut3& color);

  PatinaHost table_{};
  std::atomic<bool> preparing_ = false;
  std::mutex mutex_;
  std::vector<std::string> complaints_;
  std::vector<const PatinaCustomLobe*> lobes_;
  std::array<uint32_t, PATINA_ENTRIES> rays_{};
  PatinaAtmosphereFunction atmosphere_ = nullptr;
  char texture_ = 0;  // whose address stands for the texture
};

}  // namespace patina::shadercheck
