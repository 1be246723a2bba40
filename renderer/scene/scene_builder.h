// SPDX-License-Identifier: Apache-2.0
// RIB requests in, Scene out: the graphics state of RI 3.2, and what each request does to it.
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "renderer/scene/graphics_state.h"
#include "renderer/scene/make_request.h"
#include "renderer/scene/run_program.h"
#include "renderer/scene/scene.h"
#include "rib/archives.h"
#include "rib/handler.h"
#include "rib/parser.h"

namespace patina {

struct SceneBuilderSettings {
  std::string archivePath;  ///< searched before the RIB's own path; RI path syntax
  /// What a shader's parameter is, asked where the RIB does not declare it; may be empty.
  std::function<std::optional<Declaration>(std::string_view request, std::string_view shader,
                                           std::string_view parameter)>
      declarationOf;
  size_t blockDepth = 200000;       ///< open blocks beyond this are an error and have no effect
  size_t archiveReads = 1'000'000;  ///< archives read in all: they may read each other many times over
  bool allowPrograms = false;       ///< Procedural "RunProgram" starts other people's code
  size_t programRuns = 10'000;      ///< in all: their output may ask for more of them
  ProgramLimits program{};          ///< of each run
  /// Carries out a Make request when it is met and returns the file that was made, "" = none, which has been
  /// reported. Empty: nothing is made. Where nothing is, the texture's name stands for its picture.
  std::function<std::string(const MakeRequest&)> makeTexture;
};

/// Reads RIB and calls back at each WorldEnd. Options, and attributes set outside of worlds, hold on to the
/// next world as RI has it: FrameBegin and FrameEnd save and restore both. Errors cost their request and are
/// reported with their place. [One thread.]
class SceneBuilder final : public RibHandler {
 public:
  /// The scene belongs to the builder and changes after the call. Options and camera may be changed in it,
  /// with effect on this world only.
  using OnWorld = std::function<void(Scene&)>;

  SceneBuilder(SceneBuilderSettings settings, ErrorHandler& errors, OnWorld onWorld);
  ~SceneBuilder() override;

  /// Reads a whole RIB: a file ("-" = standard input), or text with a name for messages. A world that is
  /// still open at the end is reported and handed out. False if it could not be read to its end.
  bool readFile(const std::string& path);
  bool readText(std::string_view text, std::string_view name);

 private:
  /// Reads a delayed archive of `outer`, which does not change any more.
  SceneBuilder(const SceneBuilder& outer, const DelayedArchive& archive, ErrorHandler& errors);

  struct WorldStart;
  struct FrameStart;
  struct Notice {
    Location first;
    size_t count = 0;
  };

  // Frame structure (scene_builder.cc)
  void unhandled(std::string_view request, const Location& at) override;
  std::optional<Declaration> declarationOf(std::string_view request, std::string_view name,
                                           std::string_view parameter) override;
  void version(float, const Location&) override {}
  void declare(std::string_view, std::string_view, const Location&) override {}
  void frameBegin(int number, const Location& at) override;
  void frameEnd(const Location& at) override;
  void worldBegin(const Location& at) override;
  void worldEnd(const Location& at) override;
  void errorHandler(std::string_view style, const Location& at) override;
  void attributeBegin(const Location& at) override { open(BlockKind::Attribute, at); }
  void attributeEnd(const Location& at) override { close(BlockKind::Attribute, at); }
  void transformBegin(const Location& at) override { open(BlockKind::Transform, at); }
  void transformEnd(const Location& at) override { close(BlockKind::Transform, at); }
  void solidBegin(std::string_view operation, const Location& at) override;
  void solidEnd(const Location& at) override { close(BlockKind::Solid, at); }
  void motionBegin(Floats times, const Location& at) override;
  void motionEnd(const Location& at) override;
  void resourceBegin(const Location& at) override { open(BlockKind::Resource, at); }
  void resourceEnd(const Location& at) override { close(BlockKind::Resource, at); }

  // Options (camera_requests.cc, option_requests.cc)
  void format(int xResolution, int yResolution, float pixelAspect, const Location& at) override;
  void frameAspectRatio(float aspect, const Location& at) override;
  void screenWindow(float left, float right, float bottom, float top, const Location& at) override;
  void cropWindow(float xmin, float xmax, float ymin, float ymax, const Location& at) override;
  void projection(std::string_view name, const ParamList& params, const Location& at) override;
  void clipping(float near, float far, const Location& at) override;
  void clippingPlane(const std::array<float, 6>& pointAndNormal, const Location& at) override;
  void depthOfField(float fStop, float focalLength, float focalDistance, const Location& at) override;
  void shutter(float open, float close, const Location& at) override;
  void pixelVariance(float variance, const Location& at) override;
  void pixelSamples(float x, float y, const Location& at) override;
  void pixelFilter(std::string_view name, float xWidth, float yWidth, const Location& at) override;
  void exposure(float gain, float gamma, const Location& at) override;
  void imager(std::string_view name, const ParamList& params, const Location& at) override;
  void quantize(std::string_view type, int one, int min, int max, float dither, const Location& at) override;
  void display(std::string_view name, std::string_view type, std::string_view mode, const ParamList& params,
               const Location& at) override;
  void hider(std::string_view type, const ParamList& params, const Location& at) override;
  void colorSamples(Floats toRgb, Floats fromRgb, const Location& at) override;
  void relativeDetail(float scale, const Location& at) override;
  void option(std::string_view name, const ParamList& params, const Location& at) override;
  void integrator(std::string_view name, Handle handle, const ParamList& params, const Location& at) override;

  // Attributes (attribute_requests.cc)
  void attribute(std::string_view name, const ParamList& params, const Location& at) override;
  void color(Floats values, const Location& at) override;
  void opacity(Floats values, const Location& at) override;
  void textureCoordinates(const std::array<float, 8>& st, const Location& at) override;
  void shadingRate(float size, const Location& at) override;
  void shadingInterpolation(std::string_view type, const Location& at) override;
  void matte(bool on, const Location& at) override;
  void bound(const Bounds6&, const Location&) override {}
  void detail(const Bounds6& bound, const Location& at) override;
  void detailRange(float minVisible, float lowerTransition, float upperTransition, float maxVisible,
                   const Location& at) override;
  void geometricApproximation(std::string_view type, float value, const Location& at) override;
  void geometricRepresentation(std::string_view type, const Location& at) override;
  void orientation(std::string_view orientation, const Location& at) override;
  void reverseOrientation(const Location& at) override;
  void sides(int sides, const Location& at) override;

  // Shaders and lights (shader_requests.cc)
  void lightSource(std::string_view name, Handle handle, const ParamList& params,
                   const Location& at) override;
  void areaLightSource(std::string_view name, Handle handle, const ParamList& params,
                       const Location& at) override;
  void illuminate(Handle light, bool on, const Location& at) override;
  void surface(std::string_view name, const ParamList& params, const Location& at) override;
  void atmosphere(std::string_view name, const ParamList& params, const Location& at) override;
  void displacement(std::string_view name, const ParamList& params, const Location& at) override;
  void bxdf(std::string_view name, Handle handle, const ParamList& params, const Location& at) override;
  void camera(std::string_view name, const ParamList& params, const Location& at) override;
  void hierarchicalSubdivisionMesh(std::string_view scheme, Ints vertexCounts, Ints vertices,
                                   const SubdivisionTags& tags, const ParamList& params,
                                   const Location& at) override;
  void resource(Handle handle, std::string_view type, const ParamList& params, const Location& at) override;
  void pattern(std::string_view name, Handle handle, const ParamList& params, const Location& at) override;
  void light(std::string_view name, Handle handle, const ParamList& params, const Location& at) override;

  // Transformations (transform_requests.cc)
  void identity(const Location& at) override;
  void transform(const RibMatrix& matrix, const Location& at) override;
  void concatTransform(const RibMatrix& matrix, const Location& at) override;
  void perspective(float fieldOfView, const Location& at) override;
  void translate(float x, float y, float z, const Location& at) override;
  void rotate(float angle, float x, float y, float z, const Location& at) override;
  void scale(float x, float y, float z, const Location& at) override;
  void skew(float angle, const std::array<float, 6>& directions, const Location& at) override;
  void coordinateSystem(std::string_view name, const Location& at) override;
  void scopedCoordinateSystem(std::string_view name, const Location& at) override;
  void coordSysTransform(std::string_view name, const Location& at) override;

  // Textures (make_requests.cc)
  void makeTexture(std::string_view picture, std::string_view texture, std::string_view sWrap,
                   std::string_view tWrap, std::string_view filter, float sWidth, float tWidth,
                   const ParamList& params, const Location& at) override;
  void makeBump(std::string_view picture, std::string_view texture, std::string_view sWrap,
                std::string_view tWrap, std::string_view filter, float sWidth, float tWidth,
                const ParamList& params, const Location& at) override;
  void makeLatLongEnvironment(std::string_view picture, std::string_view texture, std::string_view filter,
                              float sWidth, float tWidth, const ParamList& params,
                              const Location& at) override;
  void makeCubeFaceEnvironment(const std::array<std::string_view, 6>& pictures, std::string_view texture,
                               float fov, std::string_view filter, float sWidth, float tWidth,
                               const ParamList& params, const Location& at) override;
  void makeShadow(std::string_view picture, std::string_view texture, const ParamList& params,
                  const Location& at) override;
  void make(MakeRequest request, const ParamList& params, const Location& at);

  // Primitives (primitive_requests.cc, quadric_requests.cc, curve_requests.cc, nurbs_requests.cc,
  // points_requests.cc, blobby_requests.cc)
  void polygon(const ParamList& params, const Location& at) override;
  void generalPolygon(Ints loopVertexCounts, const ParamList& params, const Location& at) override;
  void pointsPolygons(Ints vertexCounts, Ints vertices, const ParamList& params, const Location& at) override;
  void pointsGeneralPolygons(Ints loopCounts, Ints vertexCounts, Ints vertices, const ParamList& params,
                             const Location& at) override;
  void basis(const RibBasis& u, int uStep, const RibBasis& v, int vStep, const Location& at) override;
  void patch(std::string_view type, const ParamList& params, const Location& at) override;
  void curves(std::string_view type, Ints vertexCounts, std::string_view wrap, const ParamList& params,
              const Location& at) override;
  void patchMesh(std::string_view type, int nu, std::string_view uWrap, int nv, std::string_view vWrap,
                 const ParamList& params, const Location& at) override;
  void nuPatch(int nu, int uOrder, Floats uKnots, float uMin, float uMax, int nv, int vOrder, Floats vKnots,
               float vMin, float vMax, const ParamList& params, const Location& at) override;
  void trimCurve(Ints curvesPerLoop, Ints orders, Floats knots, Floats mins, Floats maxs, Ints counts,
                 Floats u, Floats v, Floats w, const Location& at) override;
  void subdivisionMesh(std::string_view scheme, Ints vertexCounts, Ints vertices, const SubdivisionTags& tags,
                       const ParamList& params, const Location& at) override;
  void points(const ParamList& params, const Location& at) override;
  void blobby(int leaves, Ints codes, Floats floats, Strings strings, const ParamList& params,
              const Location& at) override;
  void sphere(float radius, float zMin, float zMax, float thetaMax, const ParamList& params,
              const Location& at) override;
  void cone(float height, float radius, float thetaMax, const ParamList& params, const Location& at) override;
  void cylinder(float radius, float zMin, float zMax, float thetaMax, const ParamList& params,
                const Location& at) override;
  void hyperboloid(const std::array<float, 3>& p1, const std::array<float, 3>& p2, float thetaMax,
                   const ParamList& params, const Location& at) override;
  void paraboloid(float rMax, float zMin, float zMax, float thetaMax, const ParamList& params,
                  const Location& at) override;
  void disk(float height, float radius, float thetaMax, const ParamList& params, const Location& at) override;
  void torus(float majorRadius, float minorRadius, float phiMin, float phiMax, float thetaMax,
             const ParamList& params, const Location& at) override;
  void geometry(std::string_view type, const ParamList& params, const Location& at) override;

  // Objects, archives, conditions (object_requests.cc, archive_requests.cc)
  void objectBegin(Handle handle, const ParamList& params, const Location& at) override;
  void objectEnd(const Location& at) override { close(BlockKind::Object, at); }
  void objectInstance(Handle handle, const ParamList& params, const Location& at) override;
  void readArchive(std::string_view name, const ParamList& params, const Location& at) override;
  bool archiveBegin(std::string_view name, const ParamList& params, const Location& at) override;
  void archive(std::string_view name, InlineArchive archive, const Location& at) override;
  void procedural(std::string_view kind, Strings args, const Bounds6& bound, const Location& at) override;
  void procedural2(std::string_view kind, std::string_view boundKind, const ParamList& params,
                   const Location& at) override;
  Branch ifBegin(std::string_view condition, const ParamList& params, const Location& at) override;
  Branch elseIf(std::string_view condition, const ParamList& params, const Location& at) override;
  Branch else_(const Location& at) override;
  void ifEnd(const Location&) override {}

  // Messages
  void error(RiError code, const Location& at, std::string_view message, std::string_view key = {});
  void warning(RiError code, const Location& at, std::string_view message, std::string_view key = {});
  void countNotice(const std::string& message, const Location& at);
  void readPointOptions(const ParamList& params, const Location& at);
  /// Names an Option or Attribute (`token` may be empty: all of its name space) that changes nothing.
  void noEffect(std::string_view request, std::string_view name, std::string_view token, const Location& at);
  void reportNotices();  ///< each once, with its count

  // Blocks
  bool open(BlockKind kind, const Location& at);
  bool close(BlockKind kind, const Location& at);
  void closeTop(const Location& at);
  void endWorld();
  void finish();
  bool inWorld() const { return blocks_.isOpen(BlockKind::World); }
  bool inObject() const { return blocks_.isOpen(BlockKind::Object); }

  // Motion blocks (motion_requests.cc)
  struct MotionBlock;
  /// A transformation in a motion block; `turn` where the request was Rotate.
  struct TransformKey {
    M44d matrix;
    std::optional<Turn> turn;
  };
  bool wants(std::string_view request, const Location& at) override;
  /// Whether transformations and primitives are keys of the open motion block.
  bool takesMotionKeys() const;
  void addMotionKey(const TransformKey& key, bool absolute);
  void addMotionKey(Primitive primitive, const Location& at);
  void endMotion();
  void endTransforms(const MotionBlock& block, bool complete);

  // State
  Attributes& changeAttributes();
  uint32_t storeAttributes();  ///< index for a primitive made now; kNone inside an untouched object
  bool takeArgument(const Param& param, const std::string& subject, ShaderArgument& argument);
  uint32_t addShader(std::string_view name, const ParamList& params, const Location& at);
  uint32_t addLight(std::string_view name, Handle handle, bool isArea, const ParamList& params,
                    const Location& at);
  bool setTransform(const M44d& ctm, const Location& at);
  bool concat(const M44d& matrix, const Location& at, const std::optional<Turn>& turn = {});
  std::optional<M44d> namedTransform(std::string_view name) const;
  void setUserValues(std::string_view kind, std::string_view name, const ParamList& params);
  std::optional<bool> evaluate(std::string_view condition, const Location& at);
  void riAttribute(const ParamList& params, const Location& at);
  void userAttribute(const ParamList& params);
  void visibilityAttribute(const ParamList& params, const Location& at);
  void displacementBound(const ParamList& params);
  void diceAttribute(const ParamList& params, const Location& at);

  // Solids (solid_requests.cc)
  void endSolid();
  void placeInSolid(Primitive& primitive, std::string_view request);
  std::vector<Primitive>& primitives() {
    return inObject() ? scene_.objects.back().primitives : scene_.primitives;
  }
  std::vector<Solid>& solids() { return inObject() ? scene_.objects.back().solids : scene_.solids; }

  // Primitives
  void addPrimitive(Shape shape, const ParamList& params, const Location& at);
  void addQuadric(Quadric::Kind kind, std::initializer_list<float> values, float thetaMax,
                  const ParamList& params, const Location& at);
  void addPolygonMesh(PolygonMesh mesh, const ParamList& params, const Location& at);
  bool mayDraw(const Location& at);

  // The modern dialect
  Rgb modernLightColor(std::string_view name, const ParamList& params, const Location& at);
  void modernAreaLight(std::string_view name, Handle handle, const ParamList& params, const Location& at);
  void lightShape(std::string_view shape, const Location& at);

  // Archives
  bool readArchiveFile(std::string_view name, const Location& at);
  bool delay(std::string_view file, const Bounds6& bound, const Location& at);
  std::shared_ptr<const Scene> readDelayed(const DelayedArchive& archive, ErrorHandler& errors) const;
  /// In a delayed archive: says that a light is left out.
  bool leaveOutLight(std::string_view name, const Location& at);
  bool emits(uint32_t object) const;  ///< some primitive of the object does
  /// In a delayed archive: names a request of an option, which comes too late for the picture.
  void nameLateOption(std::string_view request, const Location& at);
  /// Finds a name in one of the maps below, or in that of the builder around this one.
  template <typename Map>
  const typename Map::mapped_type* known(Map SceneBuilder::*map, std::string_view name) const {
    for (const SceneBuilder* builder = this; builder; builder = builder->outer_)
      if (const auto found = (builder->*map).find(std::string(name)); found != (builder->*map).end())
        return &found->second;
    return nullptr;
  }
  void readProgram(Strings args, const Location& at);
  /// Carries `read` out within an attribute block, which ends whatever it left open.
  void inOwnScope(const Location& at, const std::function<void()>& read);

  SceneBuilderSettings settings_;
  const SceneBuilder* outer_ = nullptr;  // that this one reads a delayed archive of
  ErrorHandler& errors_;
  OnWorld onWorld_;
  RibParser parser_;
  Archives archives_;

  Scene scene_;      // grows while requests come; cut back to what preceded the world or frame when that ends
  Options options_;  // in force now; the scene gets a copy at WorldEnd
  Camera camera_;
  std::string patinaMode_, riMode_;  // Option "patina" "mode"; what Hider or Integrator says

  GraphicsState state_;
  BlockStack blocks_;
  size_t blocksTooDeep_ = 0;
  std::vector<GraphicsState> savedStates_;  // of Attribute, Solid, Object, World and Frame blocks
  std::vector<std::pair<M44d, Movement>> savedTransforms_;  // of Transform blocks
  std::vector<std::unique_ptr<FrameStart>> frames_;
  std::unique_ptr<WorldStart> world_;
  size_t firstWorldState_ = 0;           // of savedStates_: those before were saved outside of the world
  std::unique_ptr<MotionBlock> motion_;  // the open motion block
  M44d objectBase_;                      // where the open object was begun

  std::unordered_map<std::string, uint32_t> lightHandles_, objectHandles_;
  std::unordered_multimap<size_t, uint32_t> shadersByHash_, attributesByHash_;
  struct ScopedSystem {
    size_t depth;  // of the block that ends it
    std::string name;
    M44d previous;
  };
  std::vector<ScopedSystem> scopedSystems_;
  std::shared_ptr<const DelayedState> lastDelayed_;  // of the last request

  std::map<std::string, std::string, std::less<>> userValues_;       // "user:pass" -> value, for conditions
  std::map<std::string, std::string, std::less<>> patternTextures_;  // by handle; empty: not a texture
  std::shared_ptr<std::atomic<size_t>> programsRun_;  // by this builder and those of delayed archives
  std::map<std::string, GraphicsState, std::less<>> resources_;  // by handle
  std::map<std::string, Notice> notices_;
};

}  // namespace patina
