#include "renderd/engine/cuda/renderer.h"

#include <chrono>
#include <limits>

#include "common/try.h"
#include "renderd/engine/cuda/trace.h"

namespace diaphane::render::cuda {
namespace {

/// Allocates a larger buffer in `larger` if `buffer` cannot hold `count` elements (grown() in
/// memory.h).
template <typename T>
Result<void> grow(DeviceBuffer<T>& larger, const DeviceBuffer<T>& buffer, std::size_t count) {
  auto made = grown(buffer, count);
  DIAPHANE_TRY(made);
  larger = std::move(*made);
  return {};
}

tl::unexpected<Error> no_scene() {
  return fail(ErrorCode::kInvalid, "a scene must be set before rendering", "scene");
}

}  // namespace

Result<std::unique_ptr<FrameRenderer>> CudaRenderer::make(std::shared_ptr<const CudaVolume> volume,
                                                          DeviceShares shares, std::uint64_t seed,
                                                          std::uint64_t first_sample,
                                                          Method method) {
  std::unique_ptr<CudaRenderer> renderer(
      new CudaRenderer(std::move(volume), std::move(shares), seed, first_sample, method));
  auto stream = Stream::make();
  DIAPHANE_TRY(stream);
  auto urgent = Stream::make(true);
  DIAPHANE_TRY(urgent);
  renderer->stream_ = std::move(*stream);
  renderer->other_stream_ = std::move(*urgent);
  for (Event& event : renderer->events_) {
    auto made = Event::make();
    DIAPHANE_TRY(made);
    event = std::move(*made);
  }
  return renderer;
}

CudaRenderer::~CudaRenderer() { cudaStreamSynchronize(stream_.get()); }

Result<CudaRenderer::Tables> CudaRenderer::grown_tables(const PreparedScene& prepared) const {
  Tables larger;
  const PreparedTransfer& transfer = *prepared.transfer;
  auto acceleration = Acceleration::reserve(tables_.acceleration, *next_volume_, transfer);
  DIAPHANE_TRY(acceleration);
  larger.acceleration = std::move(*acceleration);
  DIAPHANE_TRY(grow(larger.colour, tables_.colour, transfer.colour.size()));
  if (prepared.features.has(Feature::kGloss)) {
    DIAPHANE_TRY(grow(larger.gloss, tables_.gloss, transfer.gloss.size()));
  }
  if (prepared.features.has(Feature::kEmission)) {
    DIAPHANE_TRY(grow(larger.emission, tables_.emission, transfer.emission.size()));
  }
  DIAPHANE_TRY(grow(larger.lights, tables_.lights, prepared.lights.size()));
  DIAPHANE_TRY(grow(larger.maps, tables_.maps, prepared.maps.size()));
  if (const auto& textures = prepared.textures) {
    DIAPHANE_TRY(grow(larger.textures, tables_.textures, textures->textures.size()));
    DIAPHANE_TRY(grow(larger.texels, tables_.texels, textures->texels.size()));
    DIAPHANE_TRY(grow(larger.texture_rows, tables_.texture_rows, textures->rows.size()));
  }
  return larger;
}

Result<void> CudaRenderer::upload_tables(const PreparedScene& prepared) {
  const PreparedTransfer& transfer = *prepared.transfer;
  const cudaStream_t stream = stream_.get();
  // If the transfer function is unchanged, as after a camera move, its tables are not uploaded.
  const bool other = prepared.transfer != prepared_.transfer;
  const auto wants = [&](Feature f) {
    return prepared.features.has(f) && (other || !prepared_.features.has(f));
  };
  if (wants(Feature::kGloss)) {
    DIAPHANE_TRY(upload(tables_.gloss, transfer.gloss.data(), transfer.gloss.size(), stream));
  }
  if (wants(Feature::kEmission)) {
    DIAPHANE_TRY(
        upload(tables_.emission, transfer.emission.data(), transfer.emission.size(), stream));
  }
  if (other) {
    DIAPHANE_TRY(upload(tables_.colour, transfer.colour.data(), transfer.colour.size(), stream));
  }
  if (other || prepared.labels != prepared_.labels || prepared.overlay != prepared_.overlay) {
    DIAPHANE_TRY(tables_.acceleration.rebuild_acceleration(*volume_, transfer,
                                                           prepared.labels.get(), stream));
    if (prepared.overlay) DIAPHANE_TRY(upload_second(prepared));
  }
  return upload_lights(prepared);
}

Result<void> CudaRenderer::upload_lights(const PreparedScene& prepared) {
  const cudaStream_t stream = stream_.get();
  DIAPHANE_TRY(upload(tables_.lights, prepared.lights.data(), prepared.lights.size(), stream));
  DIAPHANE_TRY(upload(tables_.maps, prepared.maps.data(), prepared.maps.size(), stream));
  // Textures that have not changed are already on the device.
  const auto& now = prepared.textures;
  if (!now || now == prepared_.textures) return {};
  DIAPHANE_TRY(upload(tables_.textures, now->textures.data(), now->textures.size(), stream));
  DIAPHANE_TRY(upload(tables_.texels, now->texels.data(), now->texels.size(), stream));
  return upload(tables_.texture_rows, now->rows.data(), now->rows.size(), stream);
}

LightArrays CudaRenderer::light_arrays() const {
  LightArrays arrays(tables_.lights.data());
  arrays.maps = tables_.maps.data();
  arrays.textures = tables_.textures.data();
  arrays.texels = tables_.texels.data();
  arrays.rows = tables_.texture_rows.data();
  return arrays;
}

void CudaRenderer::set_precedence(unsigned precedence) {
  const bool urgent = precedence > 0;
  if (urgent == urgent_) return;
  use_device();
  // Work queued on one stream must end before any begins on the other. If the device is lost, the
  // next call that can fail reports it.
  (void)cudaStreamSynchronize(stream_.get());
  std::swap(stream_, other_stream_);
  urgent_ = urgent;
}

void CudaRenderer::adopt_tables(Tables larger, const PreparedScene& prepared) {
  if (larger.acceleration.made()) {
    tables_.acceleration = std::move(larger.acceleration);
    exact_of_ = nullptr;
  }
  adopt(tables_.colour, std::move(larger.colour));
  adopt(tables_.gloss, std::move(larger.gloss));
  adopt(tables_.emission, std::move(larger.emission));
  // These buffers exist only while the scene uses them.
  if (!prepared.features.has(Feature::kGloss)) tables_.gloss = {};
  if (!prepared.features.has(Feature::kEmission)) tables_.emission = {};
  adopt(tables_.lights, std::move(larger.lights));
  adopt(tables_.maps, std::move(larger.maps));
  if (prepared.textures) {
    adopt(tables_.textures, std::move(larger.textures));
    adopt(tables_.texels, std::move(larger.texels));
    adopt(tables_.texture_rows, std::move(larger.texture_rows));
  } else {
    // These buffers exist only while the scene has textures.
    tables_.textures = {};
    tables_.texels = {};
    tables_.texture_rows = {};
  }
}

Result<void> CudaRenderer::set_scene(const diaphane::v1::Scene& scene, Canvas canvas) {
  use_device();
  const bool keeps_volume = film_ && next_volume_ == volume_;
  const auto second = second_scan();
  auto prepared = prepare_scene(scene, canvas, next_volume_->header(), next_volume_->grid(),
                                film_ ? &prepared_ : nullptr, keeps_volume ? &scene_ : nullptr,
                                next_volume_->baked(), second ? &*second : nullptr);
  DIAPHANE_TRY(prepared);
  if (method_.walk == Walk::kExact && !use_exact_walk(*prepared, method_)) {
    return fail(ErrorCode::kUnsupported, "the exact walk cannot render this scene", "estimator");
  }
  // Required allocations come first, so that the old picture remains if one of them fails.
  auto larger = grown_tables(*prepared);
  DIAPHANE_TRY(larger);
  std::optional<CudaFilm> film;
  if (!film_ || !film_->holds(canvas)) {
    auto made = CudaFilm::make(canvas);
    DIAPHANE_TRY(made);
    film = std::move(*made);
  }
  // Launches of a stopped batch may still read the tables and write to the film.
  DIAPHANE_CUDA_TRY(cudaStreamSynchronize(stream_.get()));
  volume_ = next_volume_;
  second_ = next_second_;
  adopt_tables(std::move(*larger), *prepared);
  if (film) film_ = std::move(film);
  film_->reshape(canvas);
  film_->set_curve(prepared->curve);
  DIAPHANE_TRY(upload_tables(*prepared));
  // If there is no memory for guides, pictures are not denoised.
  if (!film_->keep_guides(guided_)) DIAPHANE_TRY(film_->keep_guides(false));
  denoiser_ = film_->guides() == nullptr ? nullptr : shares_.denoisers->take();
  DIAPHANE_TRY(film_->clear(stream_.get()));
  scene_ = scene;
  prepared_ = std::move(*prepared);
  prepared_.features = prepared_.features.with(
      Feature::kSteepExtinction, prepared_.matter && tables_.acceleration.steep(prepared_.spacing));
  DIAPHANE_TRY(prepare_exact());
  DIAPHANE_TRY(choose_variants());
  // A path may continue to its last possible collision. Tracking finds about eight collisions in
  // the time of one exact walk.
  const std::uint32_t paths = exact_ ? exact_->paths() : 1;
  launch_size_.forget(1 + paths * (prepared_.bounces - 1) / 8.0,
                      std::uint64_t{canvas.width} * canvas.height, prepared_.bounces);
  launch_milliseconds_ = 0;
  seconds_ = 0;
  dropped_ = 0;
  error_samples_ = 0;
  share_ = {};
  return {};
}

Result<void> CudaRenderer::set_share(const Share& share) {
  if (!film_) return no_scene();
  DIAPHANE_TRY(film_->set_share(share));
  share_ = share;
  error_samples_ = 0;
  return {};
}

Result<bool> CudaRenderer::take_film(FilmPart& out) {
  if (!film_) return no_scene();
  use_device();
  error_samples_ = 0;
  return film_->take(out, stream_.get());
}

Result<bool> CudaRenderer::take_film_here(FilmPart& out) {
  if (!film_) return no_scene();
  use_device();
  error_samples_ = 0;
  return film_->take_here(out, stream_.get());
}

Result<void> CudaRenderer::merge_film(const FilmPart& part) {
  if (!film_) return no_scene();
  use_device();
  error_samples_ = 0;
  return film_->merge(part, stream_.get());
}

Result<void> CudaRenderer::note_launch(Flight& flight, std::uint64_t work, std::uint32_t samples) {
  // Event 0 is the start. Launch n starts at event n and ends at event n + 1.
  const auto event = [this](std::size_t n) { return events_[n % events_.size()].get(); };
  flight.work[flight.launched % flight.work.size()] = work;
  flight.samples[flight.launched % flight.samples.size()] = samples;
  ++flight.launched;
  DIAPHANE_CUDA_TRY(cudaEventRecord(event(flight.launched), stream_.get()));
  // Long launches are not queued behind each other, because a stop has to wait for all queued
  // launches.
  const std::size_t ahead = launch_milliseconds_ > LaunchSize::kTargetMs ? 1 : kAhead;
  while (flight.launched - flight.completed >= ahead) {
    const std::size_t oldest = flight.completed++;
    DIAPHANE_CUDA_TRY(cudaEventSynchronize(event(oldest + 1)));
    float ms = 0;
    DIAPHANE_CUDA_TRY(cudaEventElapsedTime(&ms, event(oldest), event(oldest + 1)));
    launch_milliseconds_ = static_cast<double>(ms);
    launch_size_.learn(flight.work[oldest % flight.work.size()], launch_milliseconds_,
                       flight.samples[oldest % flight.samples.size()]);
  }
  return {};
}

Result<void> CudaRenderer::prepare_exact() {
  if (!use_exact_walk(prepared_, method_)) {
    exact_.reset();
    return {};
  }
  const auto made = make_exact();
  if (made || made.error().code != ErrorCode::kOutOfMemory || method_.walk == Walk::kExact) {
    return made;
  }
  // Tracking needs none of this memory and converges to the same picture, though later.
  exact_.reset();
  return {};
}

Result<void> CudaRenderer::make_exact() {
  if (!exact_) exact_.emplace(shares_.workspaces->take());
  DIAPHANE_TRY(exact_->reserve(prepared_));
  if (exact_of_ == prepared_.transfer) return {};
  exact_of_ = nullptr;
  DIAPHANE_TRY(
      tables_.acceleration.rebuild_exact(*volume_, prepared_.transfer->exact, stream_.get()));
  exact_of_ = prepared_.transfer;
  return {};
}

SceneView<TextureVolume> CudaRenderer::view() const {
  SceneView<TextureVolume> view =
      view_of(prepared_, volume_->view(), tables_.acceleration.extinction(), tables_.colour.data(),
              tables_.acceleration.bounds(), light_arrays(), seed_,
              first_sample_ + share_.sequence * kSequenceSamples, method_);
  view.numbers = {share_.part, share_.parts};
  if (prepared_.matter) view.grid.occupied = tables_.acceleration.occupied();
  view.transfer.gloss = tables_.gloss.data();
  view.transfer.emission = tables_.emission.data();
  if (prepared_.labels) view.labels = {volume_->labels(), tables_.acceleration.looks()};
  if (prepared_.overlay) add_overlay(prepared_, second_.volume->view(), second_arrays(), view);
  if (exact_) {
    view.exact = exact_view_of(prepared_, volume_->grid(), volume_->view().size,
                               tables_.acceleration.pieces(), tables_.acceleration.piece_of(),
                               tables_.acceleration.skips());
  }
  return view;
}

Result<bool> CudaRenderer::trace_until(std::uint64_t target, const std::function<bool()>& stop,
                                       Flight& flight) {
  const Canvas canvas = film_->canvas();
  const SceneView<TextureVolume> scene = view();
  while (film_->drawn() < target) {
    if (stop()) return false;
    const RowCounts::Piece piece = film_->next(target, exact_ ? exact_->samples() : kMostSamples);
    std::uint32_t rows = min(launch_size_.rows(canvas.width, piece.samples, kStripeRows),
                             piece.last_row - piece.first_row);
    if (exact_) rows = min(rows, exact_->rows(piece.samples));
    const Stripe stripe{.first_row = film_->first_row() + piece.first_row,
                        .rows = rows,
                        .film_sample = piece.film_sample,
                        .samples = piece.samples,
                        .lane_shift = lane_shift_for(piece.samples, kMostLaneShift)};
    if (exact_) {
      DIAPHANE_TRY(exact_->launch(scene, stripe, film_->target(), stream_.get()));
    } else {
      const bool guided = guided_variant_ != nullptr && piece.film_sample < kGuidedSamples;
      DIAPHANE_CUDA_TRY(trace(guided ? *guided_variant_ : *variant_, scene, stripe, film_->target(),
                              stream_.get()));
    }
    film_->done(piece, rows);
    DIAPHANE_TRY(
        note_launch(flight, std::uint64_t{canvas.width} * rows * stripe.samples, stripe.samples));
  }
  return true;
}

Result<Batch> CudaRenderer::render(std::uint32_t samples, const std::function<bool()>& stop) {
  if (!film_) return no_scene();
  use_device();
  const auto start = std::chrono::steady_clock::now();
  Batch batch;
  Flight flight;
  // The kernel for this scene may be ready by now. After the first sample it is too late to change.
  if (film_->empty()) DIAPHANE_TRY(choose_variants());
  DIAPHANE_CUDA_TRY(cudaEventRecord(events_[0].get(), stream_.get()));
  const std::uint64_t before = film_->drawn();
  const auto traced = trace_until(before + samples, stop, flight);
  DIAPHANE_TRY(traced);
  batch.samples = static_cast<std::uint32_t>(film_->drawn() - before);
  auto dropped = film_->dropped(stream_.get());
  DIAPHANE_TRY(dropped);
  batch.dropped_samples = *dropped - dropped_;
  dropped_ = *dropped;
  batch.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  seconds_ += batch.seconds;
  return batch;
}

Progress CudaRenderer::progress() const {
  Progress progress;
  progress.error = std::numeric_limits<double>::infinity();
  if (!film_) return progress;
  use_device();
  progress.samples = film_->samples();
  progress.seconds = seconds_;
  // The error is computed again when the number of samples has grown by an eighth, because a
  // computation takes a tenth of the time of a short quantum.
  if (error_samples_ == 0 || progress.samples >= error_samples_ + (error_samples_ + 7) / 8) {
    // If the device is lost here, the next call that can fail reports it.
    const auto measured = film_->measure(prepared_.automatic_exposure, stream_.get());
    if (!measured) return progress;
    error_samples_ = progress.samples;
    error_ = measured->error;
    stops_ = prepared_.automatic_exposure ? automatic_stops(measured->mean) : 0;
  }
  if (progress.samples > 0) {
    progress.error = error_ * std::sqrt(double(error_samples_) / double(progress.samples));
    progress.stops = stops_;
  }
  return progress;
}

float CudaRenderer::scale() const {
  return display_scale(prepared_.exposure + (prepared_.automatic_exposure ? progress().stops : 0));
}

Result<void> CudaRenderer::display(PictureRgb8& out) {
  if (!film_) return no_scene();
  use_device();
  out.size = film_->canvas();
  out.pixels.resize(3 * film_->pixels());
  return film_->display(scale(), out.pixels.data(), stream_.get());
}

Result<void> CudaRenderer::radiance(PictureRgbF& out) {
  if (!film_) return no_scene();
  use_device();
  out.size = film_->canvas();
  out.pixels.resize(3 * film_->pixels());
  return film_->radiance(out.pixels.data(), stream_.get());
}

Result<void> CudaRenderer::choose_variants() {
  VariantStore& variants = *shares_.variants;
  if (exact_) return exact_->choose_kernels(variants, prepared_.features);
  variant_ = variants.get(kTraceKernel, prepared_.features);
  guided_variant_ = film_->guides() == nullptr
                        ? nullptr
                        : variants.get(kTraceKernel, prepared_.features.with(Feature::kGuides));
  return {};
}

float CudaRenderer::fade() {
  if (film_->guides() == nullptr || film_->samples() == 0) return 0;
  const float fade = denoiser_fade(progress().error);
  if (!(fade > 0)) {
    // No later launch writes guides.
    guided_variant_ = nullptr;
    denoiser_ = nullptr;
    (void)film_->keep_guides(false);
  }
  return fade;
}

Result<bool> CudaRenderer::display_denoised(PictureRgb8& out) {
  if (!film_) return no_scene();
  use_device();
  const float f = fade();
  if (!(f > 0)) return display(out).map([] { return false; });
  const Float3 s = prepared_.spacing;
  out.size = film_->canvas();
  out.pixels.resize(3 * film_->pixels());
  const auto done = film_->display_denoised(*denoiser_, max(s.x, max(s.y, s.z)), f, scale(),
                                            out.pixels.data(), stream_.get());
  if (done) return true;
  if (done.error().code != ErrorCode::kOutOfMemory) return tl::unexpected(done.error());
  return display(out).map([] { return false; });
}

Result<bool> CudaRenderer::radiance_denoised(PictureRgbF& out) {
  if (!film_) return no_scene();
  use_device();
  const float f = fade();
  if (!(f > 0)) return radiance(out).map([] { return false; });
  const Float3 s = prepared_.spacing;
  out.size = film_->canvas();
  out.pixels.resize(3 * film_->pixels());
  DIAPHANE_TRY(film_->radiance_denoised(*denoiser_, max(s.x, max(s.y, s.z)), f, out.pixels.data(),
                                        stream_.get()));
  return true;
}

Result<void> CudaRenderer::contents(std::vector<std::uint8_t>& out) {
  if (!film_) return no_scene();
  use_device();
  out.resize(film_->pixels());
  return film_->contents(out.data(), stream_.get());
}

std::vector<std::string> CudaRenderer::features() const {
  std::vector<std::string> names;
  for (std::uint32_t i = 0; i < kFeatureCount; ++i) {
    if (prepared_.features.has(static_cast<Feature>(i))) names.emplace_back(kFeatureNames[i]);
  }
  return names;
}

KernelReport CudaRenderer::report() const {
  KernelReport report;
  report.note = shares_.variants->note();
  if (!film_) return report;
  const Variant& variant = main_variant();
  list_features(variant.features, report);
  report.origin = variant.origin;
  report.compile_milliseconds = variant.milliseconds;
  report.from_cache = variant.from_cache;
  report.registers = variant.registers;
  report.local_bytes = variant.local_bytes;
  report.empty_cells = tables_.acceleration.empty_cells();
  report.volume_bytes = volume_->device_bytes();
  report.acceleration_bytes = tables_.acceleration.device_bytes();
  report.film_bytes = film_->device_bytes();
  if (exact_) report.shared_bytes = exact_->shared_bytes();
  if (denoiser_ && denoiser_->last_milliseconds() > 0) {
    report.denoise_milliseconds = denoiser_->last_milliseconds();
  }
  return report;
}

}  // namespace diaphane::render::cuda
