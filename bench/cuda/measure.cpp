// Measures what no picture shows: the time of a transfer function edit, the time of compiling
// kernels, and memory. Needs a device. Prints one JSON document. Times are in ms, each as median,
// minimum and maximum.
//   diaphane-cuda-measure [EDGE]        voxels along each axis of the synthetic volume, default 512
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>

#include "renderd/engine/cuda/acceleration.h"
#include "renderd/engine/cuda/engine.h"
#include "renderd/engine/cuda/trace.h"

namespace diaphane::render::cuda {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

template <typename T>
T checked(Result<T> result) {
  if (!result) {
    std::cerr << "diaphane-cuda-measure: " << result.error().message << '\n';
    std::exit(70);
  }
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

Json times_of(int runs, const std::function<void(int)>& work) {
  std::vector<double> ms;
  for (int i = 0; i < runs; ++i) {
    const auto start = Clock::now();
    work(i);
    ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
  }
  std::sort(ms.begin(), ms.end());
  return {{"median", ms[ms.size() / 2]}, {"smallest", ms.front()}, {"largest", ms.back()}};
}

/// Returns balls of dense matter in empty surroundings, with the values of a CT.
volume::Volume made_volume(std::uint32_t n) {
  volume::Volume v;
  v.header.size = {n, n, n};
  v.header.spacing = {0.5, 0.5, 0.5};
  v.header.direction = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  v.header.minimum = -1024;
  v.header.maximum = 3071;
  v.voxels.resize(std::size_t{n} * n * n);
  std::size_t i = 0;
  const int period = 96;
  for (std::uint32_t z = 0; z < n; ++z) {
    for (std::uint32_t y = 0; y < n; ++y) {
      for (std::uint32_t x = 0; x < n; ++x, ++i) {
        const int a = static_cast<int>(x) % period - 48, b = static_cast<int>(y) % period - 48,
                  c = static_cast<int>(z) % period - 48;
        v.voxels[i] =
            static_cast<std::int16_t>(std::max(3071 - 3 * (a * a + b * b + c * c), -1024));
      }
    }
  }
  return v;
}

diaphane::v1::Scene scene_with(double first) {
  diaphane::v1::Scene scene;
  auto* function = scene.mutable_transfer_function();
  function->set_extinction_per_mm(1);
  for (int channel = 0; channel < 4; ++channel) {
    auto* added = function->add_channels();
    for (int i = 0; i < 6; ++i) {
      auto* point = added->add_opacity();
      point->set_value(first + 300 * channel + 150 * i);
      point->set_opacity(i % 2 == 0 ? 0.2 : 0.9);
    }
    added->mutable_diffuse()->set_r(0.8);
  }
  scene.mutable_camera()->mutable_eye()->set_z(900);
  scene.mutable_camera()->mutable_target();
  scene.mutable_camera()->mutable_up()->set_y(1);
  scene.mutable_camera()->set_vertical_fov_degrees(30);
  auto* sky = scene.add_lights()->mutable_environment()->mutable_radiance();
  sky->set_r(1);
  sky->set_g(1);
  sky->set_b(1);
  return scene;
}

std::size_t used_bytes() {
  std::size_t free = 0, total = 0;
  cudaMemGetInfo(&free, &total);
  return total - free;
}

Json edit(const CudaVolume& volume) {
  auto stream = checked(Stream::make());
  const Int3 size = volume.view().size;
  std::vector<PreparedTransfer> tables;
  Json json;
  const auto prepare = [&](int i) {
    tables.push_back(prepare_transfer(scene_with(100 + 7 * i).transfer_function(), volume.grid(),
                                      size, {0.5f, 0.5f, 0.5f}));
  };
  json["tables_on_the_host"] = times_of(21, prepare);
  json["nodes"] = tables[0].count;
  auto made = checked(Acceleration::reserve(Acceleration{}, volume, tables[0]));
  checked(made.rebuild_acceleration(volume, tables[0], nullptr, stream.get()));
  json["majorants_with_upload"] = times_of(21, [&](int i) {
    checked(made.rebuild_acceleration(volume, tables[static_cast<std::size_t>(i)], nullptr,
                                      stream.get()));
  });
  json["acceleration_bytes"] = made.device_bytes();
  json["empty_cells"] = made.empty_cells();
  return json;
}

Json kernels(int architecture) {
  Json json = Json::array();
  std::string pattern =
      (std::filesystem::temp_directory_path() / "diaphane-measure-XXXXXX").string();
  const std::string directory = ::mkdtemp(pattern.data());
  const Features sets[] = {Features{}.with(Feature::kEnvironment),
                           Features{}.with(Feature::kAreaLights).with(Feature::kEnvironment),
                           Features{}
                               .with(Feature::kAreaLights)
                               .with(Feature::kEnvironment)
                               .with(Feature::kSurfaces)
                               .with(Feature::kGloss),
                           kAllFeatures};
  for (const Features features : sets) {
    KernelReport names;
    list_features(features, names);
    Json one{{"features", features == kAllFeatures ? Json("all") : Json(names.compiled_in)}};
    for (const char* from : {"compiled", "from_disk"}) {
      VariantStore store(KernelChoice::kExact, directory, architecture);
      const auto variant = store.get(kTraceKernel, features);
      one[from] = variant->milliseconds;
      one["registers"] = variant->registers;
      one["local_bytes"] = variant->local_bytes;
      one["from_memory"] = times_of(5, [&](int) { store.get(kTraceKernel, features); })["median"];
      if (!store.note().empty()) one["note"] = store.note();
    }
    const auto ahead =
        VariantStore(KernelChoice::kAheadOfTime, "", architecture).get(kTraceKernel, features);
    one["registers_ahead_of_time"] = ahead->registers;
    one["local_bytes_ahead_of_time"] = ahead->local_bytes;
    json.push_back(std::move(one));
  }
  std::filesystem::remove_all(directory);
  return json;
}

Json session(Engine& engine, const std::shared_ptr<const DeviceVolume>& volume) {
  Json json;
  const std::size_t before = used_bytes();
  auto renderer = checked(engine.renderer(volume, 1, 0));
  const Canvas canvas{1920, 1080};
  checked(renderer->set_scene(scene_with(100), canvas));
  checked(renderer->render(4, [] { return false; }));
  PictureRgb8 picture;
  checked(renderer->display(picture));
  json["error"] = renderer->progress().error;
  const KernelReport report = renderer->report();
  json["bytes_of_device"] = used_bytes() - before;
  json["film_bytes"] = report.film_bytes;
  json["acceleration_bytes"] = report.acceleration_bytes;
  json["edit_whole_set_scene"] =
      times_of(21, [&](int i) { checked(renderer->set_scene(scene_with(101 + i), canvas)); });
  auto scene = scene_with(100);
  checked(renderer->set_scene(scene, canvas));
  renderer->prepare_denoising(true);
  checked(renderer->set_scene(scene, canvas));
  checked(renderer->render(1, [] { return false; }));
  json["smoothed"] = checked(renderer->display_denoised(picture));
  json["film_bytes_smoothed"] = renderer->report().film_bytes;
  json["denoise_milliseconds"] = renderer->report().denoise_milliseconds.value_or(0);
  renderer->prepare_denoising(false);
  json["camera_whole_set_scene"] = times_of(21, [&](int i) {
    scene.mutable_camera()->mutable_eye()->set_x(i);
    checked(renderer->set_scene(scene, canvas));
  });
  return json;
}

int run(std::uint32_t edge) {
  EngineOptions options;
  options.kernels = KernelChoice::kAheadOfTime;
  const auto engine = checked(make_cuda_engine(options));
  cudaDeviceProp properties{};
  cudaGetDeviceProperties(&properties, 0);
  Json json{{"device", engine->info().device}, {"edge", edge}};
  const volume::Volume voxels = made_volume(edge);
  const std::size_t before = used_bytes();
  std::shared_ptr<const DeviceVolume> volume;
  json["load"] = times_of(1, [&](int) { volume = checked(engine->load(voxels)); })["median"];
  json["volume_bytes_of_device"] = used_bytes() - before;
  json["voxel_bytes"] = 2 * voxels.voxels.size();
  json["edit"] = edit(dynamic_cast<const CudaVolume&>(*volume));
  json["session_1080p"] = session(*engine, volume);
  json["kernels"] = kernels(10 * properties.major + properties.minor);
  std::cout << json.dump(1) << std::endl;
  return 0;
}

}  // namespace
}  // namespace diaphane::render::cuda

int main(int argc, char** argv) {
  const long edge = argc > 1 ? std::strtol(argv[1], nullptr, 10) : 512;
  if (edge < 1 || edge > 2048) {
    std::cerr << "usage: diaphane-cuda-measure [EDGE]\n"
                 "EDGE: voxels along each axis of the synthetic volume, 1 to 2048 (default: 512)\n";
    return 64;
  }
  return diaphane::render::cuda::run(static_cast<std::uint32_t>(edge));
}
