// Several devices that render one picture, with assistants controlled by the test and with those of
// a real engine's threads.

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <thread>

#include "renderd/composite/composite_engine.h"
#include "renderd/composite/device_thread.h"
#include "renderd/engine/cpu/engine.h"
#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render {
namespace {

constexpr Canvas kCanvas{61, 77};

/// The behaviour of a fake assistant, which renders `each` samples of its task whenever a part is
/// requested.
struct Script {
  std::uint32_t each = 4;
  bool lost = false;
  bool silent = false;
  int tasks = 0;
  std::deque<AssistPart> late;  ///< delivered before any other part
  AssistTask task;
  std::unique_ptr<FrameRenderer> renderer;
};

class ScriptedAssistant final : public Assistant {
 public:
  explicit ScriptedAssistant(std::shared_ptr<Script> script) : script_(std::move(script)) {}
  void begin(const AssistTask& task) override {
    script_->task = task;
    ++script_->tasks;
    script_->renderer->prepare_denoising(task.guided);
    ASSERT_TRUE(script_->renderer->set_scene(*task.scene, task.canvas));
    ASSERT_TRUE(script_->renderer->set_share(task.share));
    asked_ = false;
  }
  std::optional<AssistPart> take(const AssistNews&) override {
    Script& s = *script_;
    if (!s.late.empty()) {
      AssistPart part = std::move(s.late.front());
      s.late.pop_front();
      return part;
    }
    // Every second call returns nothing, as if the next part were not ready yet.
    if ((asked_ = !asked_) == false || s.lost || s.silent || s.each == 0) return std::nullopt;
    AssistPart part;
    EXPECT_TRUE(s.renderer->render(s.each, nullptr));
    EXPECT_TRUE(*s.renderer->take_film(part.film));
    part.epoch = s.task.epoch;
    part.sequence = s.task.share.sequence;
    part.seconds = 1e-3;
    return part;
  }
  bool lost() override { return script_->lost; }

 private:
  std::shared_ptr<Script> script_;
  bool asked_ = false;
};

class Composite : public ::testing::Test {
 protected:
  std::unique_ptr<FrameRenderer> renderer() { return *engine_->renderer(volume_, 7, 0); }
  std::unique_ptr<CompositeRenderer> composite(std::size_t helpers, CompositeOptions options) {
    std::vector<std::unique_ptr<Assistant>> assistants;
    for (std::size_t i = 0; i < helpers; ++i) {
      scripts_.push_back(std::make_shared<Script>());
      scripts_.back()->renderer = renderer();
      assistants.push_back(std::make_unique<ScriptedAssistant>(scripts_.back()));
    }
    return std::make_unique<CompositeRenderer>(renderer(), std::move(assistants), options);
  }
  static std::vector<float> radiance(FrameRenderer& renderer) {
    PictureRgbF picture;
    EXPECT_TRUE(renderer.radiance(picture));
    return picture.pixels;
  }
  /// Returns the picture of one device with `samples` samples of sequence 1, the first that is
  /// dealt.
  std::vector<float> alone(std::uint32_t samples, const diaphane::v1::Scene& scene) {
    const auto one = renderer();
    EXPECT_TRUE(one->set_scene(scene, kCanvas));
    EXPECT_TRUE(one->set_share({.sequence = 1}));
    EXPECT_TRUE(one->render(samples, nullptr));
    return radiance(*one);
  }
  static double largest_difference(const std::vector<float>& a, const std::vector<float>& b) {
    EXPECT_EQ(a.size(), b.size());
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      most = std::max(most, std::abs(double(a[i]) - double(b[i])) / (double(b[i]) + 1e-3));
    }
    return most;
  }
  /// Rounding error of packed means.
  static constexpr double kRounding = 0x1p-11 + 1e-5;

  std::unique_ptr<Engine> engine_ = make_cpu_engine(2);
  std::shared_ptr<const DeviceVolume> volume_ = *engine_->load(test::skull_volume());
  std::vector<std::shared_ptr<Script>> scripts_;
};

TEST_F(Composite, AveragesAndTilesReproduceTheSingleDeviceImage) {
  for (const std::size_t devices : {2u, 3u, 4u}) {
    for (const Division division : {Division::kAverage, Division::kTiles}) {
      scripts_.clear();
      const auto many = composite(devices - 1, {.division = division});
      ASSERT_TRUE(many->set_scene(test::skull_scene(), kCanvas));
      ASSERT_TRUE(many->render(4, nullptr));
      const bool tiles = division == Division::kTiles;
      const auto samples = static_cast<std::uint32_t>(tiles ? 4 : 4 * devices);
      EXPECT_EQ(many->progress().samples, samples);
      EXPECT_LT(largest_difference(radiance(*many), alone(samples, test::skull_scene())), kRounding)
          << devices << (tiles ? " tiles" : " averaged");
      EXPECT_EQ(many->composite().assistants, devices - 1);
    }
  }
}

/// The time that assistants worked counts as render time of the picture, even for parts that come
/// too late.
TEST_F(Composite, BatchReportsTheTimeOfAssistants) {
  const auto many = composite(3, {.division = Division::kAverage});
  ASSERT_TRUE(many->set_scene(test::skull_scene(), kCanvas));
  const auto first = many->render(4, nullptr);
  ASSERT_TRUE(first);
  EXPECT_NEAR(first->helped_seconds, 3e-3, 1e-12);  // a part of 1 ms from each assistant
  scripts_[0]->silent = scripts_[1]->silent = scripts_[2]->silent = true;
  const auto second = many->render(4, nullptr);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->helped_seconds, 0) << "each part once";
  AssistPart late;
  late.epoch = 77;
  late.seconds = 5e-3;
  scripts_[0]->late.push_back(std::move(late));
  const auto third = many->render(4, nullptr);
  ASSERT_TRUE(third);
  EXPECT_NEAR(third->helped_seconds, 5e-3, 1e-12);
}

/// Thesis 5.1.2: without the epoch, samples of the previous picture would appear in the new one.
TEST_F(Composite, DropsPartsOfOlderEpochs) {
  auto turned = test::skull_scene();
  turned.mutable_camera()->mutable_eye()->set_x(turned.camera().eye().x() + 300);
  for (const bool drop : {true, false}) {
    scripts_.clear();
    const auto many = composite(1, {.division = Division::kAverage, .drop_older_epochs = drop});
    ASSERT_TRUE(many->set_scene(test::skull_scene(), kCanvas));
    // The part is in transit when the camera turns.
    AssistPart late;
    ASSERT_TRUE(scripts_[0]->renderer->render(4, nullptr));
    ASSERT_TRUE(*scripts_[0]->renderer->take_film(late.film));
    late.epoch = scripts_[0]->task.epoch;
    ASSERT_TRUE(many->set_scene(turned, kCanvas));
    scripts_[0]->late.push_back(std::move(late));
    scripts_[0]->each = 0;
    ASSERT_TRUE(many->render(4, nullptr));

    const auto one = renderer();
    ASSERT_TRUE(one->set_scene(turned, kCanvas));
    ASSERT_TRUE(one->set_share({.part = 0, .parts = 2, .sequence = 1}));
    ASSERT_TRUE(one->render(4, nullptr));
    const double off = largest_difference(radiance(*many), radiance(*one));
    EXPECT_EQ(many->composite().dropped_parts, 1u);
    if (drop) {
      EXPECT_EQ(off, 0);
    } else {
      EXPECT_GT(off, 0.3) << "there is no ghost, so the test detects nothing";
    }
  }
}

TEST_F(Composite, LostAssistantCostsOnlyItsShare) {
  const auto many = composite(2, {.division = Division::kAverage});
  ASSERT_TRUE(many->set_scene(test::skull_scene(), kCanvas));
  ASSERT_TRUE(many->render(4, nullptr));
  scripts_[0]->lost = true;
  ASSERT_TRUE(many->render(4, nullptr));
  EXPECT_EQ(many->progress().samples, 4u * 3 + 4u * 2) << "its delivered samples stay";
  EXPECT_EQ(many->composite().assistants, 1u);
  // It returns and gets a share of the same picture.
  scripts_[0]->lost = false;
  ASSERT_TRUE(many->render(4, nullptr));
  EXPECT_EQ(many->progress().samples, 4u * 3 + 4u * 2 + 4u * 3);
  EXPECT_EQ(scripts_[0]->tasks, 2);
  EXPECT_EQ(scripts_[1]->tasks, 1) << "nobody else is disturbed";
  EXPECT_NE(scripts_[0]->task.share.sequence, scripts_[1]->task.share.sequence);
}

TEST_F(Composite, OthersTakeOverTheRowsOfALostAssistant) {
  const auto many = composite(2, {.division = Division::kTiles});
  ASSERT_TRUE(many->set_scene(test::skull_scene(), kCanvas));
  ASSERT_TRUE(many->render(4, nullptr));
  ASSERT_EQ(many->progress().samples, 4u);
  scripts_[0]->lost = true;
  const auto goes_on = many->render(3, nullptr);
  ASSERT_TRUE(goes_on) << goes_on.error().message;
  ASSERT_TRUE(many->render(5, nullptr));
  EXPECT_GE(many->progress().samples, 8u) << "its rows too";
  // The picture is the same within the noise of 8 samples, as estimated by the renderer.
  const auto truth = alone(64, test::skull_scene());
  const auto picture = radiance(*many);
  double squared = 0;
  std::size_t counted = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    squared += std::pow(std::min(picture[i], 1.0f) - std::min(truth[i], 1.0f), 2);
    ++counted;
  }
  EXPECT_LT(std::sqrt(squared / static_cast<double>(counted)), 0.1);
}

TEST_F(Composite, RespondingDevicesRenderAMissingBand) {
  const auto many =
      composite(2, {.division = Division::kTiles, .patience = std::chrono::milliseconds(20)});
  ASSERT_TRUE(many->set_scene(test::skull_scene(), kCanvas));
  scripts_[1]->silent = true;
  ASSERT_TRUE(many->render(2, nullptr));
  EXPECT_GE(many->progress().samples, 2u) << "the first picture is whole";
  // Waiting for bands can be interrupted.
  ASSERT_TRUE(many->set_scene(test::skull_scene(), kCanvas));
  ASSERT_TRUE(many->render(2, [] { return true; }));
}

TEST_F(Composite, IgnoresInvalidPartsFromAnAssistant) {
  const auto many = composite(1, {.division = Division::kAverage});
  ASSERT_TRUE(many->set_scene(test::skull_scene(), kCanvas));
  AssistPart bad;
  bad.epoch = 1;
  bad.film = {.width = 1000, .first_row = 7, .rows = 3, .samples = 1, .pixels = {}};
  scripts_[0]->late.push_back(bad);
  scripts_[0]->each = 0;
  ASSERT_TRUE(many->render(2, nullptr));
  EXPECT_EQ(many->progress().samples, 2u);
}

TEST_F(Composite, ChoosesTheDivisionOnceSpeedsAreKnown) {
  const auto many = composite(2, {});
  ASSERT_TRUE(many->set_scene(test::skull_scene(), kCanvas));
  EXPECT_EQ(many->composite().division, Division::kAverage) << "nothing is known yet";
  ASSERT_TRUE(many->render(4, nullptr));
  (void)many->progress();
  ASSERT_TRUE(many->set_scene(test::skull_scene(), kCanvas));
}

TEST_F(Composite, BandsBringTheGuidesOfTheDenoiser) {
  const auto many = composite(2, {.division = Division::kTiles});
  many->prepare_denoising(true);
  ASSERT_TRUE(many->set_scene(test::skull_scene(), kCanvas));
  ASSERT_TRUE(many->render(4, nullptr));
  ASSERT_EQ(many->progress().samples, 4u);
  const auto one = renderer();
  one->prepare_denoising(true);
  ASSERT_TRUE(one->set_scene(test::skull_scene(), kCanvas));
  ASSERT_TRUE(one->set_share({.sequence = 1}));
  ASSERT_TRUE(one->render(4, nullptr));
  PictureRgbF together, alone;
  const auto smoothed = many->radiance_denoised(together), expected = one->radiance_denoised(alone);
  ASSERT_TRUE(smoothed && expected && *smoothed && *expected);
  // The filter compares pixels in units of their noise, of which parts keep 2 bits (PackedPixel),
  // so its weights differ. Without the guides of a band, the pictures differ by more than half.
  EXPECT_LT(largest_difference(together.pixels, alone.pixels), 0.05);
}

/// Devices of one process, as in a renderd with several GPUs.
class CompositeEngineTest : public testing::Test {
 protected:
  void start(Division division) {
    std::vector<std::unique_ptr<Engine>> devices;
    for (int i = 0; i < 3; ++i) devices.push_back(make_cpu_engine(1));
    renderer_.reset();
    // The patience is long because a device that is late for the first picture would lose its share
    // on a slow test machine.
    engine_ = make_composite_engine(std::move(devices), nullptr,
                                    {.division = division, .patience = std::chrono::hours(1)});
    renderer_ = *engine_->renderer(*engine_->load(test::skull_volume()), 7, 0);
    ASSERT_TRUE(renderer_->set_scene(test::skull_scene(), kCanvas));
  }
  void until(const std::function<bool()>& test) {
    while (!test()) ASSERT_TRUE(renderer_->render(2, [] { return false; }));
  }
  const CompositeReport& report() const {
    return dynamic_cast<CompositeRenderer&>(*renderer_).composite();
  }
  /// Returns the root mean square difference to the picture of one device.
  double off() const {
    const auto one = make_cpu_engine(2);
    const auto truth = *one->renderer(*one->load(test::skull_volume()), 99, 0);
    EXPECT_TRUE(truth->set_scene(test::skull_scene(), kCanvas));
    EXPECT_TRUE(truth->render(60, nullptr));
    PictureRgbF a, b;
    EXPECT_TRUE(renderer_->radiance(a) && truth->radiance(b));
    double squared = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
      squared += std::pow(std::min(a.pixels[i], 1.0f) - std::min(b.pixels[i], 1.0f), 2);
    }
    return std::sqrt(squared / static_cast<double>(a.pixels.size()));
  }

  std::unique_ptr<CompositeEngine> engine_;
  std::unique_ptr<FrameRenderer> renderer_;
};

TEST_F(CompositeEngineTest, LocalDevicesRenderOneImageAndStopWithIt) {
  for (const Division division : {Division::kAverage, Division::kTiles}) {
    start(division);
    EXPECT_EQ(engine_->info().device.substr(0, 4), "3 x ");
    until([&] { return renderer_->progress().samples >= 40 && report().parts > 2; });
    EXPECT_EQ(report().dropped_parts, 0u);
    EXPECT_EQ(report().assistants, 2u);
    EXPECT_LT(off(), 0.06);
  }
}

TEST_F(CompositeEngineTest, DeviceThatItsOwnPicturesNeedLeavesAndComesBack) {
  for (const Division division : {Division::kAverage, Division::kTiles}) {
    start(division);
    until([&] { return report().parts > 2; });
    engine_->keep_for_own([](std::size_t device) { return device == 2; });
    until([&] { return report().assistants == 1; });
    const auto before = renderer_->progress().samples;
    until([&] { return renderer_->progress().samples >= before + 8; });
    engine_->keep_for_own({});
    until([&] { return report().assistants == 2; });
    until([&] { return renderer_->progress().samples >= 60; });
    EXPECT_LT(off(), 0.06);
  }
}

TEST_F(CompositeEngineTest, EveryDeviceCanBeTheHome) {
  start(Division::kAverage);
  const auto volume = *engine_->load(test::skull_volume());
  renderer_ = *engine_->home(2).renderer(volume, 7, 0);
  ASSERT_TRUE(renderer_->set_scene(test::skull_scene(), kCanvas));
  until([&] { return renderer_->progress().samples >= 40 && report().parts > 2; });
  EXPECT_LT(off(), 0.06);
  const auto alone = *renderer_of_one_device(engine_->home(1), volume, 7, 0, {});
  EXPECT_EQ(dynamic_cast<CompositeRenderer*>(alone.get()), nullptr);
}

/// Counts the calls that it gets.
class CountingRenderer final : public FrameRenderer {
 public:
  explicit CountingRenderer(std::shared_ptr<std::atomic<int>> samples)
      : samples_(std::move(samples)) {}
  Result<void> set_scene(const diaphane::v1::Scene&, Canvas) override { return {}; }
  Result<Batch> render(std::uint32_t samples, const std::function<bool()>&) override {
    *samples_ += static_cast<int>(samples);
    held_ += samples;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return Batch{samples, 0.001, 0};
  }
  Progress progress() const override { return {}; }
  Result<void> display(PictureRgb8&) override { return {}; }
  Result<void> radiance(PictureRgbF&) override { return {}; }
  Result<void> contents(std::vector<std::uint8_t>&) override { return {}; }
  Result<void> set_share(const Share&) override { return {}; }
  Result<bool> take_film(FilmPart& out) override {
    out.samples = held_;
    held_ = 0;
    return true;
  }
  std::vector<std::string> features() const override { return {}; }

 private:
  std::shared_ptr<std::atomic<int>> samples_;
  std::uint64_t held_ = 0;
};

TEST(DeviceThread, PausesWhileItsPartsAreNotTaken) {
  auto samples = std::make_shared<std::atomic<int>>(0);
  DeviceThread thread;
  const auto assistant = thread.assistant(std::make_unique<CountingRenderer>(samples), 0);
  AssistTask task;
  task.scene = std::make_shared<const diaphane::v1::Scene>();
  task.epoch = 4;
  assistant->begin(task);
  std::optional<AssistPart> part;
  for (int i = 0; i < 5000 && !part; ++i) {
    part = assistant->take({});
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_TRUE(part);
  EXPECT_EQ(part->epoch, 4u);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const int rested = *samples;
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(*samples, rested) << "a picture without viewers costs nothing";
  ASSERT_TRUE(assistant->take({}));
  for (int i = 0; i < 5000 && *samples == rested; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_GT(*samples, rested);
}

TEST(DeviceThread, HelpsNoOtherWhileItsOwnPicturesNeedIt) {
  const auto samples = std::make_shared<std::atomic<int>>(0);
  std::atomic<bool> needed{true};
  DeviceThread thread;
  thread.keep_for_own([&] { return needed.load(); });
  const auto assistant = thread.assistant(std::make_unique<CountingRenderer>(samples), 0);
  const auto becomes_lost = [&](bool lost) {
    for (int i = 0; i < 5000 && assistant->lost() != lost; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return assistant->lost() == lost;
  };
  const auto delivers = [&] {
    for (int i = 0; i < 5000; ++i) {
      if (assistant->take({})) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return false;
  };
  AssistTask task;
  task.scene = std::make_shared<const diaphane::v1::Scene>();
  assistant->begin(task);
  ASSERT_TRUE(becomes_lost(true));
  EXPECT_EQ(*samples, 0);
  needed = false;
  ASSERT_TRUE(becomes_lost(false));
  assistant->begin(task);
  ASSERT_TRUE(delivers());
  needed = true;
  ASSERT_TRUE(becomes_lost(true));
  const int before = *samples;
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(*samples, before);
  thread.keep_for_own({});
  EXPECT_TRUE(becomes_lost(false));
}

}  // namespace
}  // namespace diaphane::render
