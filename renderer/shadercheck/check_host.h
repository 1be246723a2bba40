// SPDX-License-Identifier: Apache-2.0
// A host that serves plugins with textures made of formulas, and takes down what they ask for wrongly.
#pragma once

#include <atomic>
#include <initializer_list>
#include <mutex>
#include <string>
#include <vector>

#include "patina/shader.h"

namespace patina::shadercheck {

/// Every name but "" is a texture; the same one. [any thread]
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
  uint32_t lobeData() const;  ///< numbers that they take at most
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
  char texture_ = 0;  // whose address stands for the texture
};

}  // namespace patina::shadercheck
