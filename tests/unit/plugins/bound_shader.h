// SPDX-License-Identifier: Apache-2.0
// A standard shader of the build tree, bound to arguments, for tests that call its entry points.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "renderer/shading/plugin_loader.h"
#include "renderer/shading/shader_instance.h"
#include "renderer/shading/texture_service.h"
#include "tests/unit/plugins/batch.h"

namespace patina::test {

inline ShaderArgument number(const char* name, float value) {
  return {name, ValueType::Float, 0, {value}, {}, {}, {}};
}
inline ShaderArgument integer(const char* name, int value) {
  return {name, ValueType::Integer, 0, {}, {value}, {}, {}};
}
inline ShaderArgument triple(const char* name, ValueType type, const Triple& v) {
  return {name, type, 0, {v[0], v[1], v[2]}, {}, {}, {}};
}
inline ShaderArgument text(const char* name, const std::string& value) {
  return {name, ValueType::String, 0, {}, {}, {value}, {}};
}

/// Binds, with the camera in the world's origin; every message of the binding is a failure of the test.
class BoundShader {
 public:
  BoundShader(const char* name, std::vector<ShaderArgument> arguments = {},
              const M44d& shaderToWorld = M44d(), TextureService* textures = nullptr)
      : loader_(ShaderPaths{}),
        errors_([](Severity, std::string_view message) { ADD_FAILURE() << message; }),
        host_(cameraInWorld, textures) {
    const PluginLoader::Result& found = loader_.find(name);
    if (!found.shader) throw std::runtime_error(found.error);
    instance_ = ShaderInstance::create(*found.shader, {name, std::move(arguments), shaderToWorld, {}}, host_,
                                       errors_);
    if (!instance_) throw std::runtime_error("not bound");
  }
  ~BoundShader() { host_.summarize(errors_); }
  const ShaderInstance* operator->() const { return instance_.get(); }
  const ShaderInstance& operator*() const { return *instance_; }

  /// A batch with the values of this shader.
  Batch batch(uint32_t count) const {
    Batch made(count);
    made.points.values = instance_->values().data();
    made.lightIn.values = instance_->values().data();
    return made;
  }

 private:
  static std::optional<M44d> cameraInWorld(std::string_view name) {
    return name == "camera" ? std::optional(M44d()) : std::nullopt;
  }
  PluginLoader loader_;
  ErrorHandler errors_;
  ShaderHost host_;
  std::unique_ptr<ShaderInstance> instance_;
};

inline void expectNear(const Triple& actual, const Triple& expected, float relative = 1e-6f) {
  for (size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(actual[c], expected[c], relative * (std::abs(expected[c]) + 1e-6f));
}

}  // namespace patina::test
