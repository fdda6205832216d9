#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "renderd/engine/cuda_acceleration.h"
#include "renderd/engine/cuda_exact_path.h"
#include "renderd/engine/cuda_film.h"
#include "renderd/engine/cuda_launch_size.h"
#include "renderd/engine/cuda_memory.h"
#include "renderd/engine/cuda_variants.h"
#include "renderd/engine/cuda_volume.h"
#include "renderd/engine/frame_renderer.h"
#include "renderd/scene/prepared_scene.h"

namespace diaphane::render::cuda {

/// What all sessions of a device share.
struct DeviceShares {
  std::shared_ptr<VariantStore> variants;
  std::shared_ptr<DeviceShare<CudaDenoiser>> denoisers;
  std::shared_ptr<DeviceShare<ExactWorkspace>> workspaces;
};

/// One session's picture on the device, on a stream of its own.
class CudaRenderer : public FrameRenderer {
 public:
  static Result<std::unique_ptr<FrameRenderer>> make(std::shared_ptr<const CudaVolume> volume,
                                                     DeviceShares shares, std::uint64_t seed,
                                                     std::uint64_t first_sample, Method method);
  /// Waits for what the stream still does: it writes into memory of this renderer.
  ~CudaRenderer() override;

  Result<void> set_scene(const diaphane::v1::Scene& scene, Canvas canvas) override;
  Result<Batch> render(std::uint32_t samples, const std::function<bool()>& stop) override;
  Progress progress() const override;
  Result<void> display(PictureRgb8& out) override;
  Result<void> radiance(PictureRgbF& out) override;
  Result<void> contents(std::vector<std::uint8_t>& out) override;
  void prepare_denoising(bool wanted) override { guided_ = wanted; }
  void hurry(bool urgent) override;
  Result<void> set_share(const Share& share) override;
  Result<bool> take_film(FilmPart& out) override;
  Result<bool> take_film_here(FilmPart& out) override;
  Result<void> merge_film(const FilmPart& part) override;
  Result<bool> display_denoised(PictureRgb8& out) override;
  Result<bool> radiance_denoised(PictureRgbF& out) override;
  std::vector<std::string> features() const override;
  KernelReport report() const override;

 private:
  /// Samples of one pixel that are summed in fp32 before they are folded into fp64.
  static constexpr std::uint32_t kMostSamples = 32;
  /// Launches under way at a time, so that the device never waits for the host between two.
  static constexpr std::size_t kAhead = 2;

  /// The scene's arrays on the device.
  struct Tables {
    DeviceBuffer<Float4> colour;
    DeviceBuffer<Float4> gloss, emission;  ///< nothing while no scene has needed them
    Acceleration acceleration;             ///< nothing where the one that is there is large enough
    DeviceBuffer<AreaLight> lights;
    // Of textures on lights; of one element each while the scene has none.
    DeviceBuffer<EnvironmentMap> maps;
    DeviceBuffer<LightTexture> textures;
    DeviceBuffer<Float4> texels;
    DeviceBuffer<float> texture_rows;
  };
  /// The launches of one call, to measure them and to wait for the oldest when there are enough.
  struct Flight {
    std::size_t launched = 0, seen = 0;
    std::array<std::uint64_t, kAhead + 1> work{};
  };

  CudaRenderer(std::shared_ptr<const CudaVolume> volume, DeviceShares shares, std::uint64_t seed,
               std::uint64_t first_sample, Method method)
      : volume_(std::move(volume)),
        shares_(std::move(shares)),
        seed_(seed),
        first_sample_(first_sample),
        method_(method) {}

  Result<Tables> grown_tables(const PreparedScene& prepared) const;
  Result<void> upload_tables(const PreparedScene& prepared);
  SceneView<TextureVolume> view() const;
  Result<void> upload_lights(const PreparedScene& prepared);
  LightArrays light_arrays() const;
  /// Tables and memory of the exact walk where the scene is rendered by it.
  Result<void> prepare_exact();
  Result<void> make_exact();
  /// Traces until every pixel has `target` samples; false when stopped before.
  Result<bool> trace_until(std::uint64_t target, const std::function<bool()>& stop, Flight& flight);
  Result<void> note_launch(Flight& flight, std::uint64_t work);
  /// The kernels for this scene, of the first samples and of those after.
  Result<void> choose_variants();
  /// What does most of the work.
  const Variant& main_variant() const { return exact_ ? exact_->variant() : *variant_; }
  /// The volume's device becomes the calling thread's current one.
  void use_device() const { cudaSetDevice(volume_->device()); }
  /// How far the picture is smoothed now; 0: not, and then for good: the guides are freed.
  float fade();

  std::shared_ptr<const CudaVolume> volume_;
  DeviceShares shares_;
  std::shared_ptr<CudaDenoiser> denoiser_;  ///< while this picture may be smoothed
  bool guided_ = false;
  std::uint64_t seed_;
  std::uint64_t first_sample_;
  Method method_;
  Share share_;
  Stream stream_;
  Stream other_stream_;  ///< of the other urgency
  bool urgent_ = false;
  std::array<Event, kAhead + 1> events_;

  diaphane::v1::Scene scene_;
  PreparedScene prepared_;
  Tables tables_;
  std::optional<CudaFilm> film_;                      ///< nothing before the first scene
  std::optional<ExactPath> exact_;                    ///< nothing while the scene is tracked
  std::shared_ptr<const PreparedTransfer> exact_of_;  ///< what its tables were made of
  /// Kept while the picture has samples: two kernels give the same estimate, not the same bits.
  std::shared_ptr<const Variant> variant_;
  std::shared_ptr<const Variant> guided_variant_;  ///< of the first kGuidedSamples, with guides
  LaunchSize launch_size_;
  double launch_milliseconds_ = 0;  ///< of the last that was measured
  double seconds_ = 0;
  std::uint64_t dropped_ = 0;
  /// The error costs two small kernels: estimated when somebody asks, once per number of samples.
  mutable std::uint64_t error_samples_ = 0;
  mutable double error_ = 0;
};

}  // namespace diaphane::render::cuda
