// The data that the device derives from voxels and transfer function equals that of the host to the
// last bit.
#include "renderd/engine/cuda/acceleration.h"

#include <random>

#include "tests/support/renderd/test_device.h"
#include "tests/support/renderd/test_scenes.h"

namespace diaphane::render::cuda {
namespace {

volume::Volume noise(std::uint32_t x, std::uint32_t y, std::uint32_t z, int low, int high,
                     std::uint32_t seed) {
  volume::Volume v = constant_volume(1, 0);
  v.header.size = {x, y, z};
  v.header.spacing = {0.7, 1.1, 3};
  std::mt19937 random(seed);
  v.voxels.resize(std::size_t{x} * y * z);
  // Most voxels have the lowest value, which gives empty cells and cells with one spike.
  for (auto& voxel : v.voxels) {
    const int value = random() % 500 == 0
                          ? low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1))
                          : low;
    voxel = static_cast<std::int16_t>(value);
  }
  return v;
}

class AccelerationTest : public CudaTest {
 protected:
  void SetUp() override {
    CudaTest::SetUp();
    if (engine_) stream_ = *Stream::make();
  }

  void expect_the_hosts(const volume::Volume& v, const diaphane::v1::Scene& scene) {
    const auto volume = CudaVolume::load(v);
    ASSERT_TRUE(volume) << volume.error().message;
    const Int3 size = size_of(v.header);
    ValueGrid grid = make_value_grid(v.voxels, size);
    grid.labels = make_label_grid(v.label_set, size);
    ASSERT_EQ((*volume)->grid().cells.x, grid.cells.x);
    EXPECT_EQ((*volume)->grid().whole.minimum, grid.whole.minimum);
    EXPECT_EQ((*volume)->grid().whole.maximum, grid.whole.maximum);
    std::vector<ValueRange> ranges(grid.ranges.size());
    ASSERT_EQ(cudaMemcpy(ranges.data(), (*volume)->ranges(), ranges.size() * sizeof(ValueRange),
                         cudaMemcpyDeviceToHost),
              cudaSuccess);
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      ASSERT_EQ(ranges[i].minimum, grid.ranges[i].minimum) << i;
      ASSERT_EQ(ranges[i].maximum, grid.ranges[i].maximum) << i;
    }

    const Float3 spacing{0.7f, 1.1f, 3.0f};
    auto host = prepare_transfer(scene.transfer_function(), grid, size, spacing);
    const auto host_labels = prepare_labels(scene, host, grid.labels, size, spacing);
    const auto tables =
        prepare_transfer(scene.transfer_function(), (*volume)->grid(), size, spacing);
    ASSERT_EQ(tables.count, host.count);
    const auto labels = prepare_labels(scene, tables, (*volume)->grid().labels, size, spacing);
    ASSERT_EQ(labels == nullptr, host_labels == nullptr);
    if (host_labels) {
      host.bounds = host_labels->bounds;
      host.steep = host_labels->steep;
      host.occupied = host_labels->occupied;
    }
    auto made = Acceleration::reserve(Acceleration{}, **volume, tables);
    ASSERT_TRUE(made) << made.error().message;
    // The second run shows that the remains of an earlier function have no effect.
    for (int i = 0; i < 2; ++i) {
      ASSERT_TRUE(made->rebuild_acceleration(**volume, tables, labels.get(), stream_.get()));
    }
    std::vector<float> extinction(host.extinction.size());
    std::vector<CellBounds> bounds(host.bounds.size());
    ASSERT_EQ(cudaMemcpy(extinction.data(), made->extinction(), 4 * extinction.size(),
                         cudaMemcpyDeviceToHost),
              cudaSuccess);
    ASSERT_EQ(cudaMemcpy(bounds.data(), made->bounds(), bounds.size() * sizeof(CellBounds),
                         cudaMemcpyDeviceToHost),
              cudaSuccess);
    EXPECT_EQ(extinction, host.extinction) << "with its rows of maxima";
    std::size_t empty = 0;
    for (std::size_t i = 0; i < bounds.size(); ++i) {
      ASSERT_EQ(bounds[i].minorant, host.bounds[i].minorant) << i;
      ASSERT_EQ(bounds[i].majorant, host.bounds[i].majorant) << i;
      empty += bounds[i].majorant > 0 ? 0 : 1;
    }
    EXPECT_EQ(made->steep(spacing), host.steep);
    EXPECT_DOUBLE_EQ(made->empty_cells(),
                     static_cast<double>(empty) / static_cast<double>(bounds.size()));
    const Box box = made->occupied();
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(box.low[axis], host.occupied.low[axis]) << axis;
      EXPECT_EQ(box.high[axis], host.occupied.high[axis]) << axis;
    }
  }

  Stream stream_;
};

TEST_F(AccelerationTest, MatchesTheHostForEverySizeAndRange) {
  expect_the_hosts(noise(1, 1, 1, 5, 5, 1), full_scene());
  expect_the_hosts(noise(9, 1, 70, 0, 1000, 2), full_scene());
  expect_the_hosts(noise(65, 33, 17, -1000, 3000, 3), full_scene());
  expect_the_hosts(noise(40, 41, 42, -32768, 32767, 4), full_scene());
  expect_the_hosts(lumpy_volume(50, 40, 30), full_scene());
}

TEST_F(AccelerationTest, MatchesTheHostForEmptySteepAndSpikedFunctions) {
  const auto volume = noise(65, 33, 17, -1000, 3000, 5);
  auto scene = full_scene();
  auto* channels = scene.mutable_transfer_function()->mutable_channels();
  const auto curve = [&](std::initializer_list<std::pair<double, double>> points) {
    for (auto& channel : *channels) {
      channel.clear_opacity();
      for (const auto& [value, opacity] : points) {
        auto* point = channel.add_opacity();
        point->set_value(value);
        point->set_opacity(opacity);
      }
    }
  };
  scene.mutable_transfer_function()->set_extinction_per_mm(1e4);
  curve({{5000, 0}, {6000, 1}});
  expect_the_hosts(volume, scene);
  curve({{1000.1, 0}, {1000.15, 1}, {1000.2, 0}});
  expect_the_hosts(volume, scene);
  curve({{-32768, 1}, {32767, 1}});
  expect_the_hosts(volume, scene);
  curve({{-900, 0}, {500, 1}, {600, 0.2}, {2900, 0.9}});
  expect_the_hosts(volume, scene);
}

TEST_F(AccelerationTest, MatchesTheHostForLabels) {
  auto volume = noise(65, 33, 17, -1000, 3000, 7);
  test::mark(volume, [](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return x < 20 ? 1 : y > 15 ? 2 : z > 8 ? 3 : 0;
  });
  auto scene = full_scene();
  for (const std::uint32_t number : {10, 20}) scene.add_labels()->set_number(number);
  scene.mutable_labels(0)->set_opacity(0.3);
  scene.mutable_labels(1)->set_opacity(0);
  expect_the_hosts(volume, scene);
  scene.mutable_labels(1)->set_solo(true);
  expect_the_hosts(volume, scene);
}

TEST_F(AccelerationTest, UsesLessThanTwoPercentOfALargeVolume) {
  const auto volume = CudaVolume::load(noise(160, 160, 160, -1000, 3000, 6));
  ASSERT_TRUE(volume);
  const auto tables = prepare_transfer(full_scene().transfer_function(), (*volume)->grid(),
                                       {160, 160, 160}, {1, 1, 1});
  const auto made = Acceleration::reserve(Acceleration{}, **volume, tables);
  ASSERT_TRUE(made);
  // The rows of the table have a fixed size. Only 12 bytes per cell grow with the volume.
  const std::uint64_t growing =
      made->device_bytes() - 8u * static_cast<std::uint64_t>(tables.count * rows_of(tables.count));
  EXPECT_LT(static_cast<double>(growing), 0.02 * 2 * 160 * 160 * 160);
}

}  // namespace
}  // namespace diaphane::render::cuda
