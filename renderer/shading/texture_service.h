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
#include <utility>
#include <vector>

#include "patina/shader.h"
#include "rib/error.h"

struct PatinaTextureModule;

namespace patina {

/// What becomes of the colours of texture files, which shaders are given as linear Rec.709; the rule is in
/// texture_color_module.h.
struct TextureColors {
  /// RI 3.2's letter: values are used as the file has them.
  bool asInFile = false;
  /// Path of an OpenColorIO configuration, "" = none. One that cannot be read is reported with `where`.
  std::string ocioConfig;
  Location where;
};

/// One per frame. t = 0 is the top row. [any thread]
class TextureService {
 public:
  /// `folders` are searched in their order, then the folder of the RIB that names it, then the name as it is.
  /// `budget` in bytes bounds the cache. `made` gives the pictures that names of MakeTexture requests stand
  /// for.
  TextureService(std::vector<std::string> folders, std::map<std::string, std::string> made, size_t budget,
                 ErrorHandler& errors, TextureColors colors = {});
  ~TextureService();
  TextureService(const TextureService&) = delete;
  TextureService& operator=(const TextureService&) = delete;

  enum Values { kColors, kData };  ///< data, as heights, are never converted
  /// nullptr: there is none, which is reported once per name with every path tried. The texture lives as long
  /// as the service. A name with <UDIM> or another of OpenImageIO's patterns is a set of tiles.
  PatinaTexture* open(std::string_view name, const Location& where, Values values = kColors);

  /// Reports, once per texture and with their count, look-ups that failed or found no tile. [main]
  void summarize();

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
  std::unique_ptr<PatinaTexture> find(std::string_view name, const Location& where, Values values);
  bool openTiles(PatinaTexture& texture, const std::string& pattern, Values values, std::string& error);

  std::vector<std::string> folders_;
  std::map<std::string, std::string> made_;
  size_t budget_;
  ErrorHandler& errors_;
  TextureColors colors_;
  std::mutex mutex_;
  bool triedModule_ = false;
  const PatinaTextureModule* module_ = nullptr;  // stays loaded until the process ends
  void* system_ = nullptr;
  std::map<std::pair<std::string, Values>, std::unique_ptr<PatinaTexture>> textures_;  // null: not found
};

}  // namespace patina
