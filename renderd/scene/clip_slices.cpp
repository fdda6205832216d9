#include "renderd/scene/clip_slices.h"

#include <array>
#include <cmath>

namespace diaphane::render {
namespace {

/// Restricts the view to the world points p with dot(normal, p - point) <= 0, unless that cuts off
/// no part of the box.
void add_half_space(ClipView& view, Double3 point, Double3 normal, const WorldToFrame& frame,
                    Double3 spacing) {
  const Double3 n = normalize(frame.direction(normal));
  const double most = dot(n, frame.point(point));
  bool cuts = false;
  for (unsigned i = 0; i < 8; ++i) cuts |= dot(n, frame.corner(i)) > most;
  if (!cuts) return;
  view.kept[view.count++] = {to_float(n * spacing), static_cast<float>(most)};
}

}  // namespace

ClipView prepare_clip(const diaphane::v1::Clip& clip, const WorldToFrame& frame, Double3 spacing) {
  ClipView view{};
  if (clip.has_box_low()) {
    const Double3 low = vector_of(clip.box_low()), high = vector_of(clip.box_high());
    constexpr Double3 kAxes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (const Double3& axis : kAxes) {
      add_half_space(view, low, axis * -1.0, frame, spacing);
      add_half_space(view, high, axis, frame, spacing);
    }
  }
  for (const auto& plane : clip.planes()) {
    add_half_space(view, vector_of(plane.point()), vector_of(plane.normal()), frame, spacing);
  }
  view.light_count = clip.cuts_light() ? view.count : 0;
  return view;
}

PatientAxes patient_axes(const volume::Header& header) {
  constexpr std::array<std::array<int, 3>, 6> kOrders{
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  // Rows of the direction matrix are axes of the patient, columns are axes of the voxels.
  const auto along = [&](int patient, int voxel) {
    return header.direction[static_cast<std::size_t>(3 * patient + voxel)];
  };
  PatientAxes best{};
  double most = -1;
  for (const auto& order : kOrders) {
    double sum = 0;
    for (int i = 0; i < 3; ++i) sum += std::abs(along(i, order[static_cast<std::size_t>(i)]));
    // The margin makes the first order win a tie despite rounding.
    if (sum <= most + 1e-9) continue;
    most = sum;
    for (int i = 0; i < 3; ++i) {
      best.voxel_axis[i] = order[static_cast<std::size_t>(i)];
      best.sign[i] = along(i, best.voxel_axis[i]) < 0 ? -1 : 1;
    }
  }
  return best;
}

ToneCurve curve_of(const diaphane::v1::Display& display) {
  return display.curve() == diaphane::v1::Display::FILMIC ? ToneCurve::kFilmic : ToneCurve::kLinear;
}

SlicesView prepare_slices(const diaphane::v1::Scene& scene, const volume::Header& header) {
  const diaphane::v1::Slices& s = scene.slices();
  const PatientAxes axes = patient_axes(header);
  SlicesView view{};
  float positions[3] = {-1, -1, -1};
  const diaphane::v1::Slices::Slice* slices[3] = {&s.sagittal(), &s.coronal(), &s.axial()};
  for (std::size_t i = 0; i < 3; ++i) {
    if (!slices[i]->shown()) continue;
    const auto axis = static_cast<std::size_t>(axes.voxel_axis[i]);
    const double position =
        0.5 * header.size[axis] + axes.sign[i] * slices[i]->position() / header.spacing[axis];
    if (position >= 0 && position <= header.size[axis]) {
      positions[axis] = static_cast<float>(position);
    }
  }
  view.position = {positions[0], positions[1], positions[2]};
  view.coloured = s.colouring() == diaphane::v1::Slices::TRANSFER;
  if (!view.coloured && s.window_width() > 0) {
    view.black_value = static_cast<float>(s.window_centre() - 0.5 * s.window_width());
    view.per_value = static_cast<float>(1 / s.window_width());
  }
  const double extinction = scene.transfer_function().extinction_per_mm();
  view.per_extinction = extinction > 0 ? static_cast<float>(1 / extinction) : 0.0f;
  view.curve = curve_of(scene.display());
  view.white = static_cast<float>(std::exp2(-scene.display().exposure()));
  return view;
}

bool any_slice(const SlicesView& s) {
  return s.position.x >= 0 || s.position.y >= 0 || s.position.z >= 0;
}

}  // namespace diaphane::render
