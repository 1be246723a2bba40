// SPDX-License-Identifier: Apache-2.0
// Textures for plugins: found on the search path, looked up through OpenImageIO, which is loaded with the
// first one.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "patina/shader.h"
#include "rib/error.h"

namespace patina {

class TextureModule;

/// One per frame. Classic RI rules: values are used as the file has them, t = 0 is the top row.
class TextureService {
 public:
  struct Counts {
    uint64_t opened = 0, missing = 0, lookups = 0;
    uint64_t bytes = 0;  ///< held by the cache now
  };

  /// `folders` are searched in their order, then the name is tried as it is. `budget` in bytes bounds the
  /// cache.
  TextureService(std::vector<std::string> folders, size_t budget, ErrorHandler& errors);
  ~TextureService();
  TextureService(const TextureService&) = delete;
  TextureService& operator=(const TextureService&) = delete;

  /// nullptr: there is none, which is reported once per name with every path tried. The texture lives as long
  /// as the service. [any thread]
  PatinaTexture* open(std::string_view name, const Location& where);

  /// As in PatinaHost. [any thread]
  PatinaStatus texture(PatinaTexture* texture, uint32_t count, PatinaPlane s, PatinaPlane t,
                       PatinaPlane width, PatinaOut3 color, float* alpha);
  PatinaStatus environment(PatinaTexture* texture, uint32_t count, PatinaPlane3 direction, PatinaPlane width,
                           PatinaOut3 color);
  static PatinaStatus size(PatinaTexture* texture, uint32_t* width, uint32_t* height, uint32_t* channels);

  bool loaded() const { return module_ != nullptr; }  ///< OpenImageIO has been started
  Counts counts() const;

 private:
  bool loadModule(const Location& where);

  std::vector<std::string> folders_;
  size_t budget_;
  ErrorHandler& errors_;
  mutable std::mutex mutex_;
  std::unique_ptr<TextureModule> module_;
  bool moduleFailed_ = false;
  std::map<std::string, std::unique_ptr<PatinaTexture>, std::less<>> textures_;
  uint64_t missing_ = 0;
};

}  // namespace patina
