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

struct PatinaTextureModule;

namespace patina {

/// One per frame. Classic RI rules: values are used as the file has them, t = 0 is the top row. [any thread]
class TextureService {
 public:
  /// `folders` are searched in their order, then the folder of the RIB that names it, then the name as it is.
  /// `budget` in bytes bounds the cache. `made` gives the pictures that names of MakeTexture requests stand
  /// for.
  TextureService(std::vector<std::string> folders, std::map<std::string, std::string> made, size_t budget,
                 ErrorHandler& errors);
  ~TextureService();
  TextureService(const TextureService&) = delete;
  TextureService& operator=(const TextureService&) = delete;

  /// nullptr: there is none, which is reported once per name with every path tried. The texture lives as long
  /// as the service.
  PatinaTexture* open(std::string_view name, const Location& where);

  bool loaded() const { return module_ != nullptr; }  ///< OpenImageIO has been started
  uint64_t cachedBytes() const;

  // As in PatinaHost, for textures of any service; a null texture reads 1.
  static PatinaStatus texture(PatinaTexture* texture, uint32_t count, PatinaPlane s, PatinaPlane t,
                              PatinaPlane width, PatinaOut3 color, float* alpha);
  static PatinaStatus environment(PatinaTexture* texture, uint32_t count, PatinaPlane3 direction,
                                  PatinaPlane width, PatinaOut3 color);
  static PatinaStatus size(const PatinaTexture* texture, uint32_t* width, uint32_t* height,
                           uint32_t* channels);

 private:
  void loadModule(const Location& where);
  std::unique_ptr<PatinaTexture> find(std::string_view name, const Location& where);

  std::vector<std::string> folders_;
  std::map<std::string, std::string> made_;
  size_t budget_;
  ErrorHandler& errors_;
  std::mutex mutex_;
  bool triedModule_ = false;
  const PatinaTextureModule* module_ = nullptr;  // stays loaded until the process ends
  void* system_ = nullptr;
  std::map<std::string, std::unique_ptr<PatinaTexture>, std::less<>> textures_;  // null: not found
};

}  // namespace patina
