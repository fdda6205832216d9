#include "renderd/engine/cpu/engine.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "common/try.h"
#include "renderd/engine/cpu/film.h"
#include "renderd/engine/cpu/kernel.h"
#include "renderd/engine/cpu/thread_pool.h"
#include "renderd/kernel/variants.h"
#include "renderd/scene/prepared_scene.h"

namespace diaphane::render {
namespace {

using Clock = std::chrono::steady_clock;

/// Edge in pixels of a tile, the unit of work. Tiles are small, so that all threads end at about
/// the same time.
constexpr std::uint32_t kWorkTile = 16;
/// Number of tiles per thread that a sample needs so that the threads idle little at its end.
constexpr double kTilesAThread = 8;

std::uint64_t machine_memory() {
  return static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) *
         static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

/// Returns the memory of the machine, or of the container if that is less (cgroup v2 and v1).
std::uint64_t usable_memory() {
  std::uint64_t least = machine_memory();
  for (const char* file :
       {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    std::uint64_t limit = 0;  // remains 0 if the file is missing or contains "max"
    if (std::ifstream(file) >> limit && limit > 0) least = std::min(least, limit);
  }
  return least;
}

class CpuVolume final : public DeviceVolume {
 public:
  explicit CpuVolume(const volume::Volume& volume)
      : header_(volume.header),
        voxels_(volume.voxels),
        labels_(volume.label_set.labels.voxels),
        grid_(make_value_grid(voxels_, size_of(header_))) {
    grid_.labels = make_label_grid(volume.label_set, size_of(header_));
  }

  const volume::Header& header() const override { return header_; }
  std::uint64_t device_bytes() const override {
    return voxels_.size() * sizeof(voxels_[0]) + grid_.ranges.size() * sizeof(ValueRange) +
           labels_.size() + grid_.labels.set_of_cell.size() * sizeof(std::uint32_t);
  }
  const ValueGrid& grid() const { return grid_; }
  const std::uint8_t* labels() const { return labels_.data(); }
  CpuVolumeView view() const { return {voxels_.data(), size_of(header_)}; }
  /// Returns the transfer functions baked for this phase of a scan, or null if there is one phase.
  TransferCache* baked() const { return header_.phase_count() > 1 ? &baked_ : nullptr; }
  /// Returns the transfer functions baked for this volume as the second scan of a session, whose
  /// renderer does not remember the last one.
  TransferCache* always_baked() const { return &baked_; }

 private:
  volume::Header header_;
  std::vector<std::int16_t> voxels_;
  std::vector<std::uint8_t> labels_;
  ValueGrid grid_;
  mutable TransferCache baked_;
};

/// The memory limit that all pictures of an engine share.
class FilmMemory {
 public:
  explicit FilmMemory(std::uint64_t bytes) : free_(static_cast<std::int64_t>(bytes)) {}

  bool take(std::uint64_t bytes) {
    const auto amount = static_cast<std::int64_t>(bytes);
    if (free_.fetch_sub(amount) >= amount) return true;
    free_ += amount;
    return false;
  }
  void give_back(std::uint64_t bytes) { free_ += static_cast<std::int64_t>(bytes); }

 private:
  std::atomic<std::int64_t> free_;
};

/// A part of FilmMemory, which the destructor returns.
class FilmShare {
 public:
  FilmShare(std::shared_ptr<FilmMemory> memory, std::uint64_t bytes)
      : memory_(std::move(memory)), bytes_(memory_->take(bytes) ? bytes : 0) {}
  FilmShare(FilmShare&& other) noexcept
      : memory_(std::move(other.memory_)), bytes_(std::exchange(other.bytes_, 0)) {}
  FilmShare& operator=(FilmShare&&) = delete;
  ~FilmShare() {
    if (bytes_ > 0) memory_->give_back(bytes_);
  }
  /// Returns whether there was enough memory.
  bool taken() const { return bytes_ > 0; }

 private:
  std::shared_ptr<FilmMemory> memory_;
  std::uint64_t bytes_;
};

/// Number of samples of a draft (Walk::kDraft), the smallest number whose error is known.
constexpr std::uint64_t kDraftSamples = 2;

/// A film with its share of the memory.
struct OwnedFilm {
  FilmShare memory;
  CpuFilm film;
};

/// The second scan of a session.
struct Second {
  std::shared_ptr<const CpuVolume> volume;  ///< null: none
  volume::Matrix to_first = volume::kIdentity;
  bool operator==(const Second&) const = default;
};

const Float4* table_or_null(const std::vector<Float4>& table) {
  return table.empty() ? nullptr : table.data();
}

/// A scene and the film that belongs to it.
struct Picture {
  Picture(diaphane::v1::Scene s, PreparedScene p, std::unique_ptr<OwnedFilm> f)
      : scene(std::move(s)), prepared(std::move(p)), owned(std::move(f)) {}

  CpuFilm& film() { return owned->film; }
  /// Returns the film to show, which is the draft until the film after it has a sample.
  CpuFilm& shown() { return draft && film().count() == 0 ? draft->film : film(); }
  /// Returns the film whose error is known. The draft's error bounds that of the next sample.
  CpuFilm& judged() { return draft && film().count() < kDraftSamples ? draft->film : film(); }
  std::uint64_t samples() const { return draft_samples + owned->film.count(); }

  diaphane::v1::Scene scene;
  PreparedScene prepared;
  std::unique_ptr<OwnedFilm> owned;
  /// Whether the film is a draft that another one will follow.
  bool drafting = false;
  /// A finished draft, until the error of the film after it is known.
  std::unique_ptr<OwnedFilm> draft;
  std::uint64_t draft_samples = 0;  ///< of the finished draft
  /// Number of tiles of the next sample that are done. A stopped sample continues at this tile.
  std::uint32_t tiles_done = 0;
  double seconds = 0;
};

class CpuFrameRenderer final : public FrameRenderer {
 public:
  CpuFrameRenderer(std::shared_ptr<ThreadPool> pool, std::shared_ptr<FilmMemory> films,
                   std::shared_ptr<const CpuVolume> volume, std::uint64_t seed,
                   std::uint64_t first_sample, Method method)
      : pool_(std::move(pool)),
        films_(std::move(films)),
        volume_(std::move(volume)),
        next_volume_(volume_),
        seed_(seed),
        first_sample_(first_sample),
        method_(method),
        threads_(*pool_) {
    if (method_.walk == Walk::kSoonest) method_.walk = Walk::kTracking;
  }

  Result<void> set_volume(std::shared_ptr<const DeviceVolume> volume) override {
    auto ours = std::dynamic_pointer_cast<const CpuVolume>(std::move(volume));
    if (!ours) return fail(ErrorCode::kInternal, "the volume was loaded by another engine");
    next_volume_ = std::move(ours);
    return {};
  }

  Result<void> set_second(std::shared_ptr<const DeviceVolume> volume,
                          const volume::Matrix& to_first) override {
    auto ours = std::dynamic_pointer_cast<const CpuVolume>(volume);
    if (volume && !ours) {
      return fail(ErrorCode::kInternal, "the volume was loaded by another engine");
    }
    next_second_ = {std::move(ours), to_first};
    return {};
  }

  Result<void> set_scene(const diaphane::v1::Scene& scene, Canvas canvas) override {
    const bool keeps_volume = picture_ && next_volume_ == volume_;
    std::optional<SecondScan> second;
    if (const auto& v = next_second_.volume) {
      second.emplace(SecondScan{v->header(), v->grid(), next_second_.to_first, v->always_baked(),
                                next_second_ == second_});
    }
    auto prepared = prepare_scene(scene, canvas, next_volume_->header(), next_volume_->grid(),
                                  picture_ ? &picture_->prepared : nullptr,
                                  keeps_volume ? &picture_->scene : nullptr, next_volume_->baked(),
                                  second ? &*second : nullptr);
    DIAPHANE_TRY(prepared);
    if (method_.walk == Walk::kExact && !use_exact_walk(*prepared, method_)) {
      return fail(ErrorCode::kUnsupported, "the exact walk cannot render this scene", "estimator");
    }
    auto film = new_film(*prepared);
    if (!film) return no_memory();
    volume_ = next_volume_;
    second_ = next_second_;
    picture_ = std::make_unique<Picture>(scene, *std::move(prepared), std::move(film));
    picture_->drafting =
        method_.walk == Walk::kDraft && use_exact_walk(picture_->prepared, method_);
    share_ = {};
    return {};
  }

  Result<Batch> render(std::uint32_t samples, const std::function<bool()>& stop) override {
    if (!picture_) return no_scene();
    const auto begin = Clock::now();
    end_draft();
    Batch batch;
    batch.refined = picture_->draft_samples > 0;
    if (picture_->drafting) {
      samples = static_cast<std::uint32_t>(
          std::min<std::uint64_t>(samples, kDraftSamples - picture_->film().count()));
    }
    while (batch.samples < samples && one_sample(stop)) {
      batch.dropped_samples += picture_->film().fold();
      ++batch.samples;
    }
    if (picture_->film().count() >= kDraftSamples) picture_->draft.reset();
    batch.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    picture_->seconds += batch.seconds;
    return batch;
  }

  Progress progress() const override {
    if (!picture_) return {};
    return {picture_->samples(), picture_->seconds, picture_->judged().error(), stops()};
  }

  Result<void> display(PictureRgb8& out) override {
    if (!picture_) return no_scene();
    picture_->shown().display(scale(), out);
    return {};
  }

  Result<void> radiance(PictureRgbF& out) override {
    if (!picture_) return no_scene();
    picture_->shown().radiance(out);
    return {};
  }

  Result<void> contents(std::vector<std::uint8_t>& out) override {
    if (!picture_) return no_scene();
    picture_->shown().contents(out);
    return {};
  }

  void prepare_denoising(bool enabled) override { guided_ = enabled; }
  void set_precedence(unsigned precedence) override { threads_.set_precedence(precedence); }
  void raise_precedence(unsigned precedence) override { threads_.raise_precedence(precedence); }

  Result<void> set_share(const Share& share) override {
    if (!picture_) return no_scene();
    if (method_.walk == Walk::kDraft) return FilmExchange::set_share(share);
    if (auto done = picture_->film().set_share(share); !done) return done;
    share_ = share;
    picture_->tiles_done = 0;
    return {};
  }

  Result<bool> take_film(FilmPart& out) override {
    if (!picture_) return no_scene();
    if (method_.walk == Walk::kDraft) return FilmExchange::take_film(out);
    return picture_->film().take(out);
  }

  Result<void> merge_film(const FilmPart& part) override {
    if (!picture_) return no_scene();
    if (method_.walk == Walk::kDraft) return FilmExchange::merge_film(part);
    return picture_->film().merge(part);
  }

  Result<bool> display_denoised(PictureRgb8& out) override {
    if (!picture_) return no_scene();
    return picture_->shown().display_denoised(scale(), out);
  }

  Result<bool> radiance_denoised(PictureRgbF& out) override {
    if (!picture_) return no_scene();
    return picture_->shown().radiance_denoised(out);
  }

  std::vector<std::string> features() const override {
    std::vector<std::string> names;
    for (std::uint32_t i = 0; picture_ && i < kFeatureCount; ++i) {
      if (picture_->prepared.features.has(static_cast<Feature>(i))) {
        names.emplace_back(kFeatureNames[i]);
      }
    }
    return names;
  }

  KernelReport report() const override {
    KernelReport report;
    if (!picture_) return report;
    const PreparedScene& s = picture_->prepared;
    const Features compiled = kVariants[variant_for(s.features)];
    list_features(compiled, report);
    report.origin = compiled == kAllFeatures ? KernelOrigin::kGeneral : KernelOrigin::kAheadOfTime;
    const std::vector<CellBounds>& bounds = bounds_of(s);
    const auto empty =
        std::count_if(bounds.begin(), bounds.end(), [](CellBounds b) { return !(b.majorant > 0); });
    report.empty_cells = static_cast<double>(empty) / static_cast<double>(bounds.size());
    report.volume_bytes = volume_->device_bytes();
    const ExactTables& e = s.transfer->exact;
    report.acceleration_bytes = bounds.size() * sizeof(CellBounds) + e.skips.size() +
                                e.pieces.size() * sizeof(ExtinctionPiece) +
                                e.piece_of.size() * sizeof(e.piece_of[0]);
    report.film_bytes =
        picture_->film().bytes() + (picture_->draft ? picture_->draft->film.bytes() : 0);
    return report;
  }

 private:
  static tl::unexpected<Error> no_memory() {
    return fail(ErrorCode::kOutOfMemory, "not enough memory for a picture of this size", "canvas");
  }
  static tl::unexpected<Error> no_scene() {
    return fail(ErrorCode::kInvalid, "a scene must be set before rendering", "scene");
  }

  /// Returns an empty film for the scene, or null if there is too little memory.
  std::unique_ptr<OwnedFilm> new_film(const PreparedScene& scene) {
    FilmShare memory(films_, CpuFilm::most_bytes(scene.canvas, guided_));
    if (!memory.taken()) return nullptr;
    try {
      const Float3 s = scene.spacing;
      CpuFilm film(threads_, scene.canvas, guided_, std::max({s.x, s.y, s.z}));
      film.set_curve(scene.curve);
      return std::make_unique<OwnedFilm>(OwnedFilm{std::move(memory), std::move(film)});
    } catch (const std::bad_alloc&) {
      return nullptr;
    }
  }

  /// Begins an empty film for the better estimator if the draft is finished. With too little memory
  /// for two films, tracking continues in the film of the draft.
  void end_draft() {
    if (!picture_->drafting || picture_->film().count() < kDraftSamples) return;
    picture_->drafting = false;
    auto film = new_film(picture_->prepared);
    if (!film) return;
    picture_->draft_samples = picture_->film().count();
    picture_->draft = std::exchange(picture_->owned, std::move(film));
  }

  /// Returns whether the exact walk renders the next sample.
  bool next_is_exact() const {
    if (method_.walk == Walk::kDraft && picture_->draft_samples == 0) return false;
    return use_exact_walk(picture_->prepared, method_);
  }

  /// Returns the stops that automatic exposure adds.
  double stops() const {
    const PreparedScene& scene = picture_->prepared;
    const CpuFilm& film = picture_->shown();
    if (!scene.automatic_exposure || film.count() == 0) return 0;
    return automatic_stops(film.mean());
  }
  /// Returns the factor of the radiance on the display.
  float scale() const { return display_scale(picture_->prepared.exposure + stops()); }

  /// Renders the next sample into CpuFilm::samples(). Returns false if stopped; the next call
  /// continues the sample.
  bool one_sample(const std::function<bool()>& stop) {
    const PreparedScene& s = picture_->prepared;
    const PreparedTransfer& t = *s.transfer;
    CpuScene view =
        view_of(s, volume_->view(), t.extinction.data(), t.colour.data(), bounds_of(s).data(),
                LightArrays(s), seed_, first_sample_ + share_.sequence * kSequenceSamples, method_);
    view.numbers = {share_.part, share_.parts};
    if (s.features.has(Feature::kGloss)) view.transfer.gloss = t.gloss.data();
    if (s.features.has(Feature::kEmission)) view.transfer.emission = t.emission.data();
    if (s.labels) view.labels = {volume_->labels(), s.labels->looks.data()};
    if (s.overlay) {
      const PreparedTransfer& o = *s.overlay->transfer;
      add_overlay(s, second_.volume->view(),
                  {o.extinction.data(), o.colour.data(), table_or_null(o.gloss),
                   table_or_null(o.emission), s.overlay->majorants.data()},
                  view);
    }
    const ExactTables& e = t.exact;
    view.exact = exact_view_of(s, volume_->grid(), volume_->view().size, e.pieces.data(),
                               e.piece_of.data(), e.skips.data());
    // With half as many hits, a sample takes half the time, and the error after a given time is the
    // same, so the user sees a picture twice as often.
    if (method_.walk == Walk::kDraft) {
      for (std::int32_t& count : view.exact.strata) count = (count + 1) / 2;
    }
    CpuFilm& film = picture_->film();
    Guides* guides = film.guides();
    const CpuKernel kernel =
        cpu_kernel(s.features.with(Feature::kGuides, guides != nullptr), next_is_exact());
    const Canvas size = s.canvas;
    const std::uint32_t tiles_x = (size.width + kWorkTile - 1) / kWorkTile;
    const std::uint32_t first_row = film.first_row();
    const std::uint32_t last_row = film.last_row();
    const std::uint32_t tiles_y = (last_row - first_row + kWorkTile - 1) / kWorkTile;
    const std::uint64_t sample = film.drawn();
    Sample* samples = film.samples();
    const std::uint32_t tiles = tiles_x * tiles_y;
    const std::uint32_t done = threads_.run(
        tiles,
        [&](std::uint32_t tile) {
          const std::uint32_t x = tile % tiles_x * kWorkTile;
          const std::uint32_t y = first_row + tile / tiles_x * kWorkTile;
          kernel(view, CpuTile{x, y, std::min(x + kWorkTile, size.width),
                               std::min(y + kWorkTile, last_row), sample, samples, guides});
        },
        stop, picture_->tiles_done);
    picture_->tiles_done = done < tiles ? done : 0;
    return done == tiles;
  }

  std::shared_ptr<ThreadPool> pool_;
  std::shared_ptr<FilmMemory> films_;
  std::shared_ptr<const CpuVolume> volume_;       ///< of the picture
  std::shared_ptr<const CpuVolume> next_volume_;  ///< of the next scene
  Second second_, next_second_;                   ///< likewise
  std::uint64_t seed_;
  std::uint64_t first_sample_;
  Method method_;
  RendererThreads threads_;
  bool guided_ = false;
  Share share_;
  std::unique_ptr<Picture> picture_;
};

class CpuEngine final : public Engine {
 public:
  CpuEngine(unsigned threads, std::uint64_t film_bytes, std::string no_gpu)
      : no_gpu_(std::move(no_gpu)),
        pool_(std::make_shared<ThreadPool>(threads)),
        films_(std::make_shared<FilmMemory>(film_bytes > 0 ? film_bytes : usable_memory() / 4)) {}

  EngineInfo info() const override {
    std::string device = std::to_string(pool_->threads()) +
                         (pool_->threads() == 1 ? " CPU thread (" : " CPU threads (") +
                         cpu_instructions() + ")";
    if (!no_gpu_.empty()) device += ", no GPU: " + no_gpu_;
    return {"cpu", std::move(device), machine_memory(),
            kTilesAThread * kWorkTile * kWorkTile * pool_->threads()};
  }

  Result<std::shared_ptr<const DeviceVolume>> load(const volume::Volume& volume) override {
    DIAPHANE_TRY(check_volume(volume));
    try {
      return std::make_shared<const CpuVolume>(volume);
    } catch (const std::bad_alloc&) {
      return fail(ErrorCode::kOutOfMemory, "not enough memory for a volume of this size");
    }
  }

 private:
  Result<std::unique_ptr<FrameRenderer>> make_renderer(std::shared_ptr<const DeviceVolume> volume,
                                                       std::uint64_t seed,
                                                       std::uint64_t first_sample,
                                                       Method method) override {
    auto mine = std::dynamic_pointer_cast<const CpuVolume>(std::move(volume));
    if (!mine) return fail(ErrorCode::kInternal, "the volume was loaded by another engine");
    return std::make_unique<CpuFrameRenderer>(pool_, films_, std::move(mine), seed, first_sample,
                                              method);
  }

  const std::string no_gpu_;
  std::shared_ptr<ThreadPool> pool_;
  std::shared_ptr<FilmMemory> films_;
};

}  // namespace

std::unique_ptr<Engine> make_cpu_engine(unsigned threads, std::uint64_t film_bytes,
                                        std::string no_gpu) {
  return std::make_unique<CpuEngine>(threads, film_bytes, std::move(no_gpu));
}

}  // namespace diaphane::render
