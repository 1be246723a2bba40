// SPDX-License-Identifier: Apache-2.0
// What a Make request may write, from what, and whether it has to.
#include "renderer/shading/texture_maker.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>

#include "renderer/base/statistics.h"
#include "renderer/shading/plugin_loader.h"
#include "renderer/shading/texture_loader.h"
#include "rib/sandbox.h"

namespace patina {
namespace {

namespace fs = std::filesystem;

STAT_COUNTER("Textures/made", texturesMade);
STAT_COUNTER("Textures/made before", texturesUpToDate);

constexpr std::string_view kRequests[] = {"MakeTexture", "MakeBump", "MakeLatLongEnvironment",
                                          "MakeCubeFaceEnvironment", "MakeShadow"};

/// RI's filters by OpenImageIO's names.
constexpr std::pair<std::string_view, const char*> kFilters[] = {{"box", "box"},
                                                                 {"triangle", "triangle"},
                                                                 {"catmull-rom", "catmull-rom"},
                                                                 {"gaussian", "gaussian"},
                                                                 {"sinc", "sinc"},
                                                                 {"b-spline", "bspline"},
                                                                 {"disk", "disk"},
                                                                 {"mitchell", "mitchell"},
                                                                 {"blackman-harris", "blackman-harris"},
                                                                 {"", ""},
                                                                 {"lanczos", "lanczos3"}};

/// What is wrong with a name that a RIB writes to; "" = nothing.
std::string nameProblem(const fs::path& name, bool allowPaths) {
  if (!name.has_filename() || name.filename() == "." || name.filename() == "..") return "it names no file";
  if (allowPaths) return {};
  if (std::string problem = writeProblem(name.string()); !problem.empty()) return problem;
  const bool climbs = std::ranges::find(name, "..") != name.end();
  return name.is_absolute() || climbs
             ? "RIBs write textures below the working folder, but for --allow-texture-paths"
             : "";
}

std::optional<std::string> findPicture(const std::string& name, const std::vector<std::string>& folders) {
  std::error_code failed;
  for (const std::string& path : textureCandidates(name, folders))
    if (readProblem(path).empty() && fs::is_regular_file(path, failed)) return path;
  return std::nullopt;
}

bool isNewer(const fs::path& target, const std::vector<std::string>& pictures) {
  std::error_code failed;
  const auto time = fs::last_write_time(target, failed);
  return !failed && std::ranges::all_of(pictures, [&](const std::string& picture) {
    const auto of = fs::last_write_time(picture, failed);
    return !failed && of < time;
  });
}

}  // namespace

std::string makeTexture(const MakeRequest& request, const TextureMaking& settings, ErrorHandler& errors) {
  const std::string_view what = kRequests[static_cast<size_t>(request.kind)];
  const auto refuse = [&](RiError code, const std::string& why) {
    errors.report(Severity::Error, code, request.where,
                  fmt::format("{} \"{}\": {}", what, request.texture, why));
    return std::string();
  };
  const fs::path target(request.texture);
  if (const std::string problem = nameProblem(target, settings.allowPaths); !problem.empty())
    return refuse(RiError::BadArgument, problem);
  const bool hasWraps = request.kind == MakeRequest::Kind::Texture || request.kind == MakeRequest::Kind::Bump;
  if (hasWraps)
    for (const std::string& wrap : {request.sWrap, request.tWrap})
      if (wrap != "black" && wrap != "periodic" && wrap != "clamp")
        return refuse(RiError::BadToken,
                      fmt::format("wrap mode \"{}\": expected black, periodic or clamp", wrap));
  const auto filter = std::ranges::find(kFilters, std::string_view(request.filter),
                                        [](const auto& entry) { return entry.first; });
  if (filter == std::end(kFilters))
    return refuse(RiError::BadToken,
                  fmt::format("filter \"{}\": expected box, triangle, catmull-rom, gaussian, sinc, b-spline, "
                              "disk, mitchell, blackman-harris or lanczos",
                              request.filter));

  // The pictures.
  std::vector<std::string> folders = splitSearchPath(settings.texturePath, {});
  for (std::string& folder : splitSearchPath(request.searchPath, {})) folders.push_back(std::move(folder));
  if (request.where.file && fs::path(*request.where.file).has_parent_path())
    folders.push_back(fs::path(*request.where.file).parent_path().string());
  std::vector<std::string> pictures;
  std::error_code failed;
  for (const std::string& name : request.pictures) {
    const std::optional<std::string> path = findPicture(name, folders);
    if (!path) return refuse(RiError::NoFile, fmt::format("there is no picture \"{}\"", name));
    if (fs::equivalent(*path, target, failed))
      return refuse(RiError::BadArgument, "a texture cannot take the place of its picture");
    pictures.push_back(*path);
  }
  const std::string place = fs::absolute(target, failed).string();
  if (isNewer(target, pictures)) {
    ++texturesUpToDate;
    return place;
  }

  // The texture.
  std::string tried;
  const PatinaTextureModule* const module = loadTextureModule(tried);
  if (!module) return refuse(RiError::System, "no texture module; tried:" + tried);
  if (fs::exists(target, failed) && !module->is_picture(target.c_str()))
    return refuse(RiError::System, "there is such a file, which is no picture and is left");
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, failed))
    return refuse(RiError::System, fmt::format("there is no folder {}", folder.string()));
  const fs::path temporary =
      folder / fmt::format(".{}.{}.part", target.filename().string(), static_cast<long>(getpid()));
  const std::string output = temporary.string();
  std::vector<const char*> names;
  for (const std::string& picture : pictures) names.push_back(picture.c_str());
  const std::string wraps = hasWraps                                    ? request.sWrap + "," + request.tWrap
                            : request.kind == MakeRequest::Kind::Shadow ? "clamp,clamp"
                                                                        : "periodic,clamp";
  const bool data = request.kind == MakeRequest::Kind::Bump || request.kind == MakeRequest::Kind::Shadow;
  PatinaTextureToMake make{};
  make.kind = request.kind == MakeRequest::Kind::LatLong    ? PATINA_MAKE_LATLONG
              : request.kind == MakeRequest::Kind::CubeFace ? PATINA_MAKE_CUBE_FACES
              : request.kind == MakeRequest::Kind::Shadow   ? PATINA_MAKE_SHADOW
                                                            : PATINA_MAKE_TEXTURE;
  make.picture_count = static_cast<uint32_t>(names.size());
  make.pictures = names.data();
  make.output = output.c_str();
  make.format = target.extension() == ".exr" ? "openexr" : "tiff";
  make.wrap_modes = wraps.c_str();
  make.filter = filter->second;
  make.color_space = data || settings.asInFile ? "raw" : request.colorSpace.c_str();
  make.ocio_config = settings.ocioConfig.c_str();
  make.fov = request.fov;
  std::array<char, 1024> error{};
  if (!module->make(&make, error.data(), error.size())) {
    fs::remove(temporary, failed);
    return refuse(RiError::BadFile, fmt::format("it cannot be made: {}", error.data()));
  }
  fs::rename(temporary, target, failed);
  if (failed) {
    const std::string reason = failed.message();
    fs::remove(temporary, failed);
    return refuse(RiError::System, reason);
  }
  ++texturesMade;
  return place;
}

}  // namespace patina
