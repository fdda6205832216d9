#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "renderd/engine/cuda/acceleration.h"
#include "renderd/engine/cuda/exact_path.h"
#include "renderd/engine/cuda/film.h"
#include "renderd/engine/cuda/launch_size.h"
#include "renderd/engine/cuda/memory.h"
#include "renderd/engine/cuda/variants.h"
#include "renderd/engine/cuda/volume.h"
#include "renderd/engine/frame_renderer.h"
#include "renderd/scene/prepared_scene.h"

namespace diaphane::render::cuda {

/// The resources that all sessions of a device share.
struct DeviceShares {
  std::shared_ptr<VariantStore> variants;
  std::shared_ptr<DeviceShare<CudaDenoiser>> denoisers;
  std::shared_ptr<DeviceShare<ExactWorkspace>> workspaces;
};

/// Renders one session's picture on the device, in a stream of its own.
class CudaRenderer : public FrameRenderer {
 public:
  static Result<std::unique_ptr<FrameRenderer>> make(std::shared_ptr<const CudaVolume> volume,
                                                     DeviceShares shares, std::uint64_t seed,
                                                     std::uint64_t first_sample, Method method);
  /// Waits for the stream, because its work writes to memory of this renderer.
  ~CudaRenderer() override;

  Result<void> set_volume(std::shared_ptr<const DeviceVolume> volume) override;
  Result<void> set_second(std::shared_ptr<const DeviceVolume> volume,
                          const volume::Matrix& to_first) override;
  Result<void> set_scene(const diaphane::v1::Scene& scene, Canvas canvas) override;
  Result<Batch> render(std::uint32_t samples, const std::function<bool()>& stop) override;
  Progress progress() const override;
  Result<void> display(PictureRgb8& out) override;
  Result<void> radiance(PictureRgbF& out) override;
  Result<void> contents(std::vector<std::uint8_t>& out) override;
  void prepare_denoising(bool enabled) override { guided_ = enabled; }
  void set_precedence(unsigned precedence) override;
  Result<void> set_share(const Share& share) override;
  Result<bool> take_film(FilmPart& out) override;
  Result<bool> take_film_here(FilmPart& out) override;
  Result<void> merge_film(const FilmPart& part) override;
  Result<bool> display_denoised(PictureRgb8& out) override;
  Result<bool> radiance_denoised(PictureRgbF& out) override;
  std::vector<std::string> features() const override;
  KernelReport report() const override;

 private:
  /// Number of samples of one pixel that are summed in fp32 before the sum is added to the fp64
  /// total.
  static constexpr std::uint32_t kMostSamples = 32;
  /// Number of launches in flight, so that the device never waits for the host between launches.
  static constexpr std::size_t kAhead = 2;

  /// The scene's arrays on the device.
  struct Tables {
    DeviceBuffer<Float4> colour;
    DeviceBuffer<Float4> gloss, emission;  ///< empty unless the scene needs them
    Acceleration acceleration;  ///< empty in grown_tables() if the current one is large enough
    DeviceBuffer<AreaLight> lights;
    // Environment maps, and the textures of lights, whose buffers are empty without textures.
    DeviceBuffer<EnvironmentMap> maps;
    DeviceBuffer<LightTexture> textures;
    DeviceBuffer<Float4> texels;
    DeviceBuffer<float> texture_rows;
  };
  /// The second scan of a scene and its arrays on the device (renderer_second.cpp).
  struct Second {
    std::shared_ptr<const CudaVolume> volume;  ///< null: none
    volume::Matrix to_first = volume::kIdentity;
    bool operator==(const Second&) const = default;
  };
  struct SecondTables {
    Acceleration acceleration;
    DeviceBuffer<Float4> colour, gloss, emission;
  };
  /// The launches of one call of render(). The call measures them, and waits for the oldest launch
  /// if too many are in flight.
  struct Flight {
    std::size_t launched = 0, completed = 0;
    std::array<std::uint64_t, kAhead + 1> work{};
    std::array<std::uint32_t, kAhead + 1> samples{};  ///< per pixel
  };

  CudaRenderer(std::shared_ptr<const CudaVolume> volume, DeviceShares shares, std::uint64_t seed,
               std::uint64_t first_sample, Method method)
      : volume_(std::move(volume)),
        next_volume_(volume_),
        shares_(std::move(shares)),
        seed_(seed),
        first_sample_(first_sample),
        method_(method) {}

  Result<Tables> grown_tables(const PreparedScene& prepared) const;
  /// Adopts the tables that grew, and frees optional tables that the scene does not use.
  void adopt_tables(Tables larger, const PreparedScene& prepared);
  Result<void> upload_tables(const PreparedScene& prepared);
  SceneView<TextureVolume> view() const;
  std::optional<SecondScan> second_scan() const;
  /// Allocates and uploads the tables of the second scan, and adds it to the acceleration.
  Result<void> upload_second(const PreparedScene& prepared);
  OverlayArrays second_arrays() const;
  Result<void> upload_lights(const PreparedScene& prepared);
  LightArrays light_arrays() const;
  /// Prepares tables and memory of the exact walk if the scene uses it.
  Result<void> prepare_exact();
  Result<void> make_exact();
  /// Traces until every pixel of the share has `target` samples. Returns false if stopped earlier.
  Result<bool> trace_until(std::uint64_t target, const std::function<bool()>& stop, Flight& flight);
  Result<void> note_launch(Flight& flight, std::uint64_t work, std::uint32_t samples);
  /// Chooses the kernels for this scene: one for the first samples with guides, and one for the
  /// rest.
  Result<void> choose_variants();
  /// Returns the kernel that does most of the work.
  const Variant& main_variant() const { return exact_ ? exact_->variant() : *variant_; }
  /// Makes the volume's device current for the calling thread.
  void use_device() const { cudaSetDevice(volume_->device()); }
  /// Returns the current strength of denoising. When it reaches 0, the guides are freed and the
  /// picture is never denoised again.
  float fade();
  /// Returns the factor of the radiance on the display.
  float scale() const;

  std::shared_ptr<const CudaVolume> volume_;       ///< of the picture
  std::shared_ptr<const CudaVolume> next_volume_;  ///< of the next scene
  Second second_, next_second_;                    ///< likewise
  SecondTables second_tables_;                     ///< empty if there was never a second scan
  DeviceShares shares_;
  std::shared_ptr<CudaDenoiser> denoiser_;  ///< null unless this picture may be denoised
  bool guided_ = false;
  std::uint64_t seed_;
  std::uint64_t first_sample_;
  Method method_;
  Share share_;
  Stream stream_;
  Stream other_stream_;  ///< stream of the priority that is not in use
  bool urgent_ = false;
  std::array<Event, kAhead + 1> events_;

  diaphane::v1::Scene scene_;
  PreparedScene prepared_;
  Tables tables_;
  std::optional<CudaFilm> film_;                      ///< empty before the first scene
  std::optional<ExactPath> exact_;                    ///< empty if the scene is tracked
  std::shared_ptr<const PreparedTransfer> exact_of_;  ///< source of the tables of the exact walk
  /// The tracking kernel. It stays the same while the picture has samples, because different
  /// kernels give different bits of the same estimate.
  std::shared_ptr<const Variant> variant_;
  std::shared_ptr<const Variant> guided_variant_;  ///< for the first kGuidedSamples, with guides
  LaunchSize launch_size_;
  double launch_milliseconds_ = 0;  ///< duration of the last measured launch
  double seconds_ = 0;
  std::uint64_t dropped_ = 0;
  /// Number of samples at the last measurement of the error, which takes two small kernels.
  mutable std::uint64_t error_samples_ = 0;
  mutable double error_ = 0;
  mutable double stops_ = 0;  ///< Progress::stops
};

}  // namespace diaphane::render::cuda
