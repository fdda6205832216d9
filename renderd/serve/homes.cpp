#include "renderd/serve/homes.h"

#include <algorithm>
#include <tuple>

#include "renderd/composite/composite_engine.h"

namespace diaphane::render {

std::size_t choose_home(const std::vector<HomeLoad>& loads) {
  const auto least =
      std::min_element(loads.begin(), loads.end(), [](const HomeLoad& a, const HomeLoad& b) {
        return std::tie(a.waiting, a.guests) < std::tie(b.waiting, b.guests);
      });
  return static_cast<std::size_t>(least - loads.begin());
}

Homes::Homes(Engine& engine, const std::function<std::unique_ptr<Runner>(const Engine&)>& runner)
    : engine_(engine) {
  auto* composite = dynamic_cast<CompositeEngine*>(&engine);
  const std::size_t devices = composite != nullptr ? composite->devices() : 1;
  for (std::size_t d = 0; d < devices; ++d) {
    Engine& home = composite != nullptr ? composite->home(d) : engine;
    devices_.push_back({&home, runner(home), std::make_shared<std::atomic<std::size_t>>(0)});
  }
  if (composite == nullptr) return;
  composite->keep_for_own([this](std::size_t d) { return devices_[d].runner->waiting() > 0; });
}

Homes::~Homes() {
  stop();
  if (auto* composite = dynamic_cast<CompositeEngine*>(&engine_)) composite->keep_for_own({});
}

std::shared_ptr<const Home> Homes::take() {
  const std::lock_guard lock(mutex_);
  std::vector<HomeLoad> loads;
  for (const Device& device : devices_) {
    loads.push_back({device.runner->waiting(), device.guests->load()});
  }
  const Device& chosen = devices_[choose_home(loads)];
  ++*chosen.guests;
  return {new Home{*chosen.engine, *chosen.runner}, [guests = chosen.guests](const Home* home) {
            --*guests;
            delete home;
          }};
}

void Homes::stop() {
  for (const Device& device : devices_) device.runner->stop();
}

double Homes::busy_seconds() const {
  double seconds = 0;
  for (const Device& device : devices_) seconds += device.runner->busy_seconds();
  return seconds / static_cast<double>(devices_.size());
}

RunnerTimes Homes::times() const {
  RunnerTimes mean;
  const auto count = static_cast<double>(devices_.size());
  for (const Device& device : devices_) {
    const RunnerTimes one = device.runner->times();
    mean.rendering += one.rendering / count;
    mean.scenes += one.scenes / count;
    mean.pictures += one.pictures / count;
    mean.busy += one.busy / count;
    mean.idle += one.idle / count;
    mean.deciding += one.deciding / count;
    mean.policy += one.policy / count;
    mean.quanta += one.quanta;
    mean.switches += one.switches;
  }
  return mean;
}

double Homes::waiting() const {
  double sessions = 0;
  for (const Device& device : devices_) sessions += static_cast<double>(device.runner->waiting());
  return sessions / static_cast<double>(devices_.size());
}

double Homes::summed_error() const {
  double error = 0;
  for (const Device& device : devices_) error += device.runner->summed_error();
  return error;
}

std::vector<const ProgressMonitor*> Homes::progress() const {
  std::vector<const ProgressMonitor*> all;
  for (const Device& device : devices_) all.push_back(&device.runner->progress());
  return all;
}

}  // namespace diaphane::render
