// SPDX-License-Identifier: Apache-2.0
// Building a frame, ambient light.
#include "renderer/integrators/world.h"

#include <fmt/format.h>

#include <cstdlib>
#include <stdexcept>

#include "renderer/base/sampling.h"
#include "renderer/base/statistics.h"
#include "renderer/integrators/passes.h"
#include "renderer/shading/work_place.h"
#include "rib/search_path.h"

namespace patina {
namespace {

void checkMoves(const ShaderInstance* displacement, const ShaderBinding& binding, ErrorHandler& errors) {
  if (displacement && !displacement->active(PATINA_ENTRY_DISPLACEMENT))
    errors.report(Severity::Warning, RiError::NoShader, binding.where,
                  "Displacement \"" + binding.name + "\" moves nothing");
}

/// `shader` if it is one for Atmosphere.
const ShaderInstance* checkAir(const ShaderInstance* shader, const ShaderBinding& binding,
                               ErrorHandler& errors) {
  if (!shader || shader->hasAtmosphere()) return shader;
  errors.report(Severity::Error, RiError::NoShader, binding.where,
                "\"" + binding.name + "\" is no shader for Atmosphere");
  return nullptr;
}

}  // namespace

World::World(const Scene& scene, const RenderSettings& settings, ErrorHandler& errors)
    : scene_(scene), settings_(settings), errors_(errors), camera_(scene.camera, scene.options) {
  if (camera_.singular()) throw std::runtime_error("the camera's transformation is singular");
  const Options& options = scene.options;
  samplesPerPixel_ = samplePlan(options, settings).most;
  frameSeed_ = mixBits(static_cast<uint64_t>(std::max(0, settings.seed.value_or(options.seed))));
  loadShaders();
  {
    PhaseTimer timer("Geometry");
    displacement_ = std::make_unique<DisplacementShading>(shaderPointers_, !scene.delayed.empty());
    const bool displaces = displacement_->isNeeded(scene) || !scene.delayed.empty();
    geometry_ = std::make_unique<Geometry>(scene, camera_, errors, displaces ? displacement_.get() : nullptr);
  }
  {
    PhaseTimer timer("Acceleration structures");
    accel_ = std::make_unique<Accel>(*geometry_);
    hosts_[0]->setAccel(accel_.get());
  }
  std::vector<const ShaderInstance*> surfaces = shaderPointers_;  // the default surface is the last
  shading_ = std::make_unique<SurfaceShading>(*geometry_, std::move(surfaces));
  lights_ = std::make_unique<Lights>(*geometry_, shaderPointers_);
  if (geometry_->hasDelayed()) {
    lightLists_.makeRoom(), lightListOf_.makeRoom();
    geometry_->setListener(this);
  }
  addLightLists(geometry_->mainPart());
}

World::~World() = default;

/// nullptr: there is no such shader, or it cannot be used, which is reported.
std::unique_ptr<ShaderInstance> World::makeShader(const ShaderBinding& binding, const char* role,
                                                  ShaderHost& host) {
  const PatinaShader* shader = loader_->load(binding.name, role, errors_, binding.where);
  return shader ? ShaderInstance::create(*shader, binding, host, errors_) : nullptr;
}

void World::loadShaders() {
  PhaseTimer timer("Shaders");
  const auto searchPath = [&](const char* kind) {
    const auto found = scene_.options.searchPaths.find(kind);
    return found == scene_.options.searchPaths.end() ? std::string() : found->second;
  };
  ShaderPaths paths;
  if (!settings_.shaderPath.empty()) paths.commandLine.push_back(settings_.shaderPath);
  paths.option = searchPath("shader");
  paths.allowPaths = settings_.allowShaderPaths;
  loader_ = std::make_unique<PluginLoader>(paths);
  std::vector<std::string> textureFolders = splitSearchPath(settings_.texturePath, {});
  for (std::string& folder : splitSearchPath(searchPath("texture"), {}))
    textureFolders.push_back(std::move(folder));
  const char* const ocio = std::getenv("OCIO");
  TextureColors colors{settings_.classic, scene_.options.ocioConfig, scene_.options.ocioWhere};
  if (colors.ocioConfig.empty() && ocio) colors.ocioConfig = ocio;
  textures_ = std::make_unique<TextureService>(
      std::move(textureFolders), scene_.options.madeTextures,
      static_cast<size_t>(std::max(scene_.options.textureKb, 1024)) * 1024, errors_, std::move(colors));
  hosts_.push_back(std::make_unique<ShaderHost>(
      [this](std::string_view name) -> std::optional<M44d> {
        if (name == "camera") return scene_.camera.worldToCamera.inverse();
        const auto found = scene_.coordinateSystems.find(std::string(name));
        if (found == scene_.coordinateSystems.end()) return std::nullopt;
        return found->second;
      },
      textures_.get()));
  hosts_[0]->setReplay([this](const V3f& at) { return howToReplay(at); });

  // Only shaders that something in the scene is bound to are loaded.
  std::vector<const char*> role(scene_.shaders.size(), nullptr);
  std::vector<bool> isDisplacement(scene_.shaders.size(), false), isAir(scene_.shaders.size(), false);
  for (const Attributes& attributes : scene_.attributes) {
    if (attributes.surface != kNone) role[attributes.surface] = "Surface";
    if (attributes.displacement != kNone) {
      role[attributes.displacement] = "Displacement";
      isDisplacement[attributes.displacement] = true;
    }
    if (attributes.atmosphere != kNone) {
      role[attributes.atmosphere] = "Atmosphere";
      isAir[attributes.atmosphere] = true;
    }
  }
  for (const Light& light : scene_.lights)
    if (light.shader != kNone) role[light.shader] = light.isArea ? "AreaLightSource" : "LightSource";
  airShaders_.growTo(scene_.shaders.size() + 1);
  const ShaderBinding fallback{"defaultsurface", {}, M44d(), {}};
  // Requests that differ by user attributes alone share an instance, unless the shader has read them.
  std::vector<const ShaderInstance*> shared(scene_.shaders.size(), nullptr);  // by ShaderBinding::alike
  for (size_t k = 0; k <= scene_.shaders.size(); ++k) {
    const bool isDefault = k == scene_.shaders.size();
    const ShaderBinding& binding = isDefault ? fallback : scene_.shaders[k];
    std::unique_ptr<ShaderInstance> made;
    const ShaderInstance* instance = nullptr;
    if (isDefault || role[k]) {
      const size_t alike = std::min<size_t>(binding.alike, k);  // by hand-made scenes it is not said
      if (!isDefault) instance = shared[alike];
      if (!instance) {
        made = makeShader(binding, isDefault ? "Surface" : role[k], *hosts_[0]);
        instance = made.get();
        if (!isDefault && instance && !instance->readsUserAttributes()) shared[alike] = instance;
      }
    }
    if (!isDefault && isDisplacement[k]) checkMoves(instance, binding, errors_);
    airShaders_[k] = !isDefault && isAir[k] ? checkAir(instance, binding, errors_) : nullptr;
    if (isDefault && !instance) throw std::runtime_error("the plugin 'defaultsurface' cannot be used");
    tried_.push_back(isDefault || role[k]);
    shaderPointers_.push_back(instance);
    shaders_.push_back(std::move(made));
  }
}

/// The shaders of a delayed archive.
void World::begin(GeometryPart& part) {
  const Scene& scene = *part.scene;
  part.firstShader = static_cast<uint32_t>(shaders_.size());
  shaders_.resize(shaders_.size() + scene.shaders.size());
  tried_.resize(shaders_.size(), false);
  airShaders_.growTo(shaders_.size());
  shading_->growTo(shaders_.size());
  displacement_->growTo(shaders_.size());
  if (!scene.shaders.empty()) {
    // Coordinate systems that the archive defines are known to its own shaders.
    const auto find = [&part, frame = hosts_[0].get()](std::string_view name) -> std::optional<M44d> {
      for (const GeometryPart* p = &part; p->around; p = p->around)
        if (const auto found = p->scene->coordinateSystems.find(std::string(name));
            found != p->scene->coordinateSystems.end())
          return found->second;
      return frame->spaceToWorld(name, M44d());
    };
    hosts_.push_back(std::make_unique<ShaderHost>(find, textures_.get()));
    hosts_.back()->setReplay([this](const V3f& at) { return howToReplay(at); });
    hosts_.back()->setAccel(accel_.get());
    hostOf_[&part] = hosts_.back().get();
  }
  // A shader of a scene around this one may be used by nothing else, and not be loaded yet.
  enum class Role { Surface, Displacement, Atmosphere };
  const auto want = [&](uint32_t shader, Role role) {
    if (shader == kNone) return;
    const bool isDisplacement = role == Role::Displacement;
    const uint32_t index = part.shader(shader);
    const ShaderInstance* known = shaders_[index].get();
    if (!known && index < shaderPointers_.size()) known = shaderPointers_[index];
    if (role == Role::Atmosphere && tried_[index] && !airShaders_[index] && known && known->hasAtmosphere())
      airShaders_[index] = known;
    if (tried_[index]) return;
    const GeometryPart& owner = part.ofShader(shader);
    const ShaderBinding& binding = owner.scene->shaders[shader];
    tried_[index] = true;
    shaders_[index] = makeShader(binding,
                                 isDisplacement             ? "Displacement"
                                 : role == Role::Atmosphere ? "Atmosphere"
                                                            : "Surface",
                                 owner.around ? *hostOf_.at(&owner) : *hosts_[0]);
    shading_->setShader(index, shaders_[index].get());
    displacement_->setShader(index, shaders_[index].get());
    if (isDisplacement) checkMoves(shaders_[index].get(), binding, errors_);
    if (role == Role::Atmosphere) airShaders_[index] = checkAir(shaders_[index].get(), binding, errors_);
  };
  for (const Attributes& attributes : part.attributes) {
    want(attributes.surface, Role::Surface);
    want(attributes.displacement, Role::Displacement);
    want(attributes.atmosphere, Role::Atmosphere);
  }
}

/// What is known by placement.
void World::end(const GeometryPart& part) {
  shading_->append(part);
  addLightLists(part);
}

std::string World::replayCommand(int x0, int y0, int x1, int y1) const {
  // The crop window's first pixel is ceil(resolution * x0), its last ceil(resolution * x1 - 1).
  const auto share = [](int edge, int resolution) {
    return std::clamp((edge - 0.5) / std::max(resolution, 1), 0.0, 1.0);
  };
  const int width = scene_.options.xResolution, height = scene_.options.yResolution;
  return fmt::format("patina --crop {:.7g} {:.7g} {:.7g} {:.7g} -o replay.exr {}", share(x0, width),
                     share(x1, width), share(y0, height), share(y1, height),
                     settings_.replay.empty() ? "FILE.rib" : settings_.replay);
}

/// The end of a message about a point: the pixel where it is seen, if that is being made, or all pixels that
/// are.
std::string World::howToReplay(const V3f& at) const {
  const WorkPlace& place = WorkPlace::current();
  if (place.empty()) return "; it was made for no pixel in particular";
  std::string pixel;
  const V3f seen = camera_.toCamera(at);
  if (seen.z > 0 || !camera_.perspective()) {
    const V2f raster = camera_.toRaster(seen);
    if (raster.x >= static_cast<float>(place.x0) && raster.x < static_cast<float>(place.x1) &&
        raster.y >= static_cast<float>(place.y0) && raster.y < static_cast<float>(place.y1))
      pixel = fmt::format(", pixel ({}, {})", static_cast<int>(raster.x), static_cast<int>(raster.y));
  }
  return fmt::format("{}; pixels {} to {} by {} to {} were being made, as this does: {}", pixel, place.x0,
                     place.x1 - 1, place.y0, place.y1 - 1,
                     replayCommand(place.x0, place.y0, place.x1, place.y1));
}

void World::summarize(ErrorHandler& errors) {
  for (const auto& host : hosts_) host->summarize(errors);
  textures_->summarize();
}

void World::addLightLists(const GeometryPart& part) {
  lightListOf_.growTo(part.endPlacement);
  for (uint32_t k = part.firstPlacement; k < part.endPlacement; ++k) {
    const std::vector<uint32_t>& wanted = geometry_->attributes(geometry_->placements()[k]).lights;
    const auto [found, isNew] = knownLists_.try_emplace(wanted, static_cast<uint32_t>(lightLists_.size()));
    lightListOf_[k] = found->second;
    if (isNew) lightLists_.push_back(LightList(*lights_, wanted));
  }
}

ShadingPoint World::seenAt(ShadingPoint point) const {
  if (!geometry_->placements()[point.placement].moves) return point;
  if (camera_.perspective())
    point.I = normalizedOr(point.P - camera_.eye(), point.I);
  else
    point.I = camera_.viewDirection();
  // It may have turned away since: it is looked at from as far behind as in front.
  if (const float behind = point.I.dot(point.Ng); behind > 0) point.I -= point.Ng * (2 * behind);
  return point;
}

void World::addAmbient(std::span<const ShadingPoint> points, std::span<const SurfaceTerms> terms,
                       std::span<Rgb> radiance) const {
  thread_local std::vector<V3f> positions;
  thread_local std::vector<Rgb> color;
  thread_local std::vector<uint32_t> which;
  for (uint32_t light = 0; light < lights_->count(); ++light) {
    if (lights_->kind(light) != PATINA_LIGHT_AMBIENT) continue;
    positions.clear(), which.clear();
    for (uint32_t i = 0; i < points.size(); ++i) {
      const LightList& list = lightsOf(points[i].placement);
      if (isBlack(terms[i].ambient) ||
          std::find(list.ambient.begin(), list.ambient.end(), light) == list.ambient.end())
        continue;
      positions.push_back(points[i].P);
      which.push_back(i);
    }
    if (which.empty()) continue;
    color.resize(which.size());
    lights_->ambient(light, positions, color);
    for (size_t k = 0; k < which.size(); ++k) radiance[which[k]] += terms[which[k]].ambient * color[k];
  }
}

}  // namespace patina
