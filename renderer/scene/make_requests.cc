// SPDX-License-Identifier: Apache-2.0
// Textures to be made of pictures: MakeTexture and its like.
#include <fmt/format.h>

#include "renderer/scene/scene_builder.h"

namespace patina {

void SceneBuilder::make(MakeRequest request, const ParamList& params, const Location& at) {
  request.where = at;
  request.ocioConfig = options_.ocioConfig;
  const std::string_view space = params.stringValue("colorspace", "");
  if (space.empty() || space == "srgb" || space == "linear" || space == "raw")
    request.colorSpace = space;
  else
    error(RiError::BadToken, at, fmt::format("\"colorspace\" \"{}\": expected srgb, linear or raw", space));
  params.reportUnread(errors_, "a Make request", std::array<std::string_view, 1>{"colorspace"});
  if (request.texture.empty() || request.pictures.front().empty())
    return error(RiError::BadArgument, at, "a texture and its picture need names");
  if (const auto path = options_.searchPaths.find("texture"); path != options_.searchPaths.end())
    request.searchPath = path->second;
  std::string made;
  if (settings_.makeTexture) made = settings_.makeTexture(request);
  if (made.empty() && request.kind == MakeRequest::Kind::CubeFace) return;  // six are no picture of it
  options_.madeTextures.insert_or_assign(request.texture, made.empty() ? request.pictures.front() : made);
}

void SceneBuilder::makeTexture(std::string_view picture, std::string_view texture, std::string_view sWrap,
                               std::string_view tWrap, std::string_view filter, float, float,
                               const ParamList& params, const Location& at) {
  MakeRequest request;
  request.kind = MakeRequest::Kind::Texture, request.pictures = {std::string(picture)};
  request.texture = texture, request.sWrap = sWrap, request.tWrap = tWrap, request.filter = filter;
  make(std::move(request), params, at);
}

void SceneBuilder::makeBump(std::string_view picture, std::string_view texture, std::string_view sWrap,
                            std::string_view tWrap, std::string_view filter, float, float,
                            const ParamList& params, const Location& at) {
  MakeRequest request;
  request.kind = MakeRequest::Kind::Bump, request.pictures = {std::string(picture)};
  request.texture = texture, request.sWrap = sWrap, request.tWrap = tWrap, request.filter = filter;
  make(std::move(request), params, at);
}

void SceneBuilder::makeLatLongEnvironment(std::string_view picture, std::string_view texture,
                                          std::string_view filter, float, float, const ParamList& params,
                                          const Location& at) {
  MakeRequest request;
  request.kind = MakeRequest::Kind::LatLong, request.pictures = {std::string(picture)};
  request.texture = texture, request.filter = filter;
  make(std::move(request), params, at);
}

void SceneBuilder::makeCubeFaceEnvironment(const std::array<std::string_view, 6>& pictures,
                                           std::string_view texture, float fov, std::string_view filter,
                                           float, float, const ParamList& params, const Location& at) {
  MakeRequest request;
  request.kind = MakeRequest::Kind::CubeFace, request.pictures.assign(pictures.begin(), pictures.end());
  request.texture = texture, request.fov = fov, request.filter = filter;
  if (!(fov >= 90 && fov < 179))
    return error(RiError::Range, at, fmt::format("field of view {}: expected 90 to 179 degrees", fov));
  make(std::move(request), params, at);
}

void SceneBuilder::makeShadow(std::string_view picture, std::string_view texture, const ParamList& params,
                              const Location& at) {
  MakeRequest request;
  request.kind = MakeRequest::Kind::Shadow, request.pictures = {std::string(picture)};
  request.texture = texture;
  make(std::move(request), params, at);
}

}  // namespace patina
