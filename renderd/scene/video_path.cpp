#include "renderd/scene/video_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "renderd/scene/camera.h"
#include "renderd/scene/presets.h"
#include "renderd/scene/scene_mix.h"

namespace diaphane::render {
namespace {

namespace v1 = diaphane::v1;

/// A rotation from the camera's axes to the world.
struct Quaternion {
  double w = 1, x = 0, y = 0, z = 0;
};

double dot(const Quaternion& a, const Quaternion& b) {
  return a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
}
Quaternion scaled(const Quaternion& q, double by) {
  return {q.w * by, q.x * by, q.y * by, q.z * by};
}
Quaternion plus(const Quaternion& a, const Quaternion& b) {
  return {a.w + b.w, a.x + b.x, a.y + b.y, a.z + b.z};
}
Quaternion normalised(const Quaternion& q) { return scaled(q, 1 / std::sqrt(dot(q, q))); }

/// Converts the rotation matrix with these columns (Shepperd 1978: the largest component first).
Quaternion quaternion_of(const CameraAxes& axes) {
  const Double3 &r = axes.right, &u = axes.up, &b = axes.back;
  const std::array<double, 4> squares{1 + r.x + u.y + b.z, 1 + r.x - u.y - b.z, 1 - r.x + u.y - b.z,
                                      1 - r.x - u.y + b.z};
  switch (std::max_element(squares.begin(), squares.end()) - squares.begin()) {
    case 0:
      return normalised({squares[0], u.z - b.y, b.x - r.z, r.y - u.x});
    case 1:
      return normalised({u.z - b.y, squares[1], r.y + u.x, b.x + r.z});
    case 2:
      return normalised({b.x - r.z, r.y + u.x, squares[2], u.z + b.y});
    default:
      return normalised({r.y - u.x, b.x + r.z, u.z + b.y, squares[3]});
  }
}

Double3 rotated(const Quaternion& q, Double3 v) {
  const Double3 axis{q.x, q.y, q.z};
  const Double3 t = cross(axis, v) * 2.0;
  return v + t * q.w + cross(axis, t);
}

/// A camera pose in numbers that can be interpolated.
struct Pose {
  Double3 target{};
  double log_distance = 0;
  Quaternion rotation;
};

Pose pose_of(const v1::Camera& camera) {
  const Double3 eye = vector_of(camera.eye()), target = vector_of(camera.target());
  return {target, std::log(length(eye - target)), quaternion_of(CameraAxes(camera))};
}

/// Interpolates on the great circle through both, or extrapolates along it.
Quaternion slerp(const Quaternion& a, const Quaternion& b, double part) {
  const double cosine = std::clamp(dot(a, b), -1.0, 1.0);
  const double angle = std::acos(cosine);
  if (angle < 1e-6) return normalised(plus(scaled(a, 1 - part), scaled(b, part)));
  const double sine = std::sin(angle);
  if (sine < 1e-6) return part < 0.5 ? a : b;  // opposite rotations have no unique shortest arc
  return normalised(plus(scaled(a, std::sin((1 - part) * angle) / sine),
                         scaled(b, std::sin(part * angle) / sine)));
}

Pose mix(const Pose& a, const Pose& b, double part) {
  return {a.target + (b.target - a.target) * part,
          a.log_distance + (b.log_distance - a.log_distance) * part,
          slerp(a.rotation, b.rotation, part)};
}

/// Returns the distance between two views, as the motion in the picture relative to the distance of
/// the camera.
double apart(const Pose& a, const Pose& b) {
  const double distance = std::exp((a.log_distance + b.log_distance) / 2);
  const double angle = 2 * std::acos(std::min(1.0, std::abs(dot(a.rotation, b.rotation))));
  return length(b.target - a.target) / distance + std::abs(b.log_distance - a.log_distance) + angle;
}

/// Interpolates between the middle two of four poses with Barry and Goldman's pyramid of linear
/// interpolations.
Pose on_curve(const std::array<Pose, 4>& p, double part) {
  std::array<double, 4> t{};
  for (std::size_t i = 1; i < 4; ++i) {
    t[i] = t[i - 1] + std::sqrt(std::max(apart(p[i - 1], p[i]), 1e-6));
  }
  const double at = t[1] + (t[2] - t[1]) * part;
  const auto between = [&](const Pose& a, const Pose& b, std::size_t first, std::size_t last) {
    return mix(a, b, (at - t[first]) / (t[last] - t[first]));
  };
  const Pose a1 = between(p[0], p[1], 0, 1), a2 = between(p[1], p[2], 1, 2),
             a3 = between(p[2], p[3], 2, 3);
  return between(between(a1, a2, 0, 2), between(a2, a3, 1, 3), 1, 2);
}

void set(v1::Vec3& to, Double3 v) {
  to.set_x(v.x);
  to.set_y(v.y);
  to.set_z(v.z);
}

void set_pose(v1::Camera& camera, const Pose& pose) {
  const Double3 back = rotated(pose.rotation, {0, 0, 1});
  set(*camera.mutable_target(), pose.target);
  set(*camera.mutable_eye(), pose.target + back * std::exp(pose.log_distance));
  set(*camera.mutable_up(), rotated(pose.rotation, {0, 1, 0}));
}

/// Returns the poses of all keys. The sign of each quaternion is chosen for the shorter way from
/// the one before.
std::vector<Pose> poses_of(const std::vector<v1::Scene>& keys) {
  std::vector<Pose> poses;
  for (const v1::Scene& key : keys) {
    Pose pose = pose_of(key.camera());
    if (!poses.empty() && dot(poses.back().rotation, pose.rotation) < 0) {
      pose.rotation = scaled(pose.rotation, -1);
    }
    poses.push_back(pose);
  }
  return poses;
}

Result<void> check_side(std::uint32_t side, const char* field) {
  if (side >= kShortestFileSide && side <= kLongestVideoSide && side % 2 == 0) return {};
  return fail(ErrorCode::kInvalid,
              "A video must be 16 to 1920 pixels wide and high, in even numbers.", field);
}

Result<void> check_phases(const v1::Video& video, std::uint32_t phases) {
  if (video.phase_cycles() > 0 && phases < 2) {
    return fail(ErrorCode::kInvalid, "This scan has no phases to play.", "phaseCycles");
  }
  if (video.phase_cycles() > video.frames()) {
    return fail(ErrorCode::kInvalid, "A video needs at least one frame per cycle of the phases.",
                "phaseCycles");
  }
  if (video.path() == v1::Video::STANDING && video.phase_cycles() == 0) {
    return fail(ErrorCode::kInvalid,
                "A video must play the phases of the scan if its camera does not move.",
                "phaseCycles");
  }
  return {};
}

v1::Scene view_at(const v1::Video& video, const std::vector<v1::Scene>& keys, std::uint32_t index) {
  if (video.path() == v1::Video::STANDING) return keys.front();
  if (video.path() == v1::Video::TURNTABLE) {
    return turned_about_target(keys.front(), static_cast<double>(index) / video.frames());
  }
  const double at = static_cast<double>(index) / (video.frames() - 1);
  return on_tour(keys, at * static_cast<double>(keys.size() - 1));
}

}  // namespace

v1::Scene turned_about_target(const v1::Scene& scene, double turn) {
  v1::Scene turned = scene;
  v1::Camera& camera = *turned.mutable_camera();
  const double angle = 2 * std::numbers::pi * turn, c = std::cos(angle), s = std::sin(angle);
  const auto about_axis = [&](Double3 v) {
    return Double3{c * v.x - s * v.y, s * v.x + c * v.y, v.z};
  };
  const Double3 target = vector_of(camera.target());
  set(*camera.mutable_eye(), target + about_axis(vector_of(camera.eye()) - target));
  set(*camera.mutable_up(), about_axis(vector_of(camera.up())));
  return turned;
}

v1::Scene on_tour(const std::vector<v1::Scene>& keys, double at) {
  const auto last = static_cast<double>(keys.size() - 1);
  const double clamped = std::clamp(at, 0.0, last);
  const auto first = static_cast<std::size_t>(std::min(std::floor(clamped), last - 1));
  const double part = clamped - static_cast<double>(first);
  if (part == 0) return keys[first];
  if (part == 1) return keys[first + 1];
  const std::vector<Pose> poses = poses_of(keys);
  const Pose &a = poses[first], &b = poses[first + 1];
  // The path is extrapolated linearly before the first and beyond the last key.
  const Pose before = first > 0 ? poses[first - 1] : mix(a, b, -1);
  const Pose after = first + 2 < poses.size() ? poses[first + 2] : mix(a, b, 2);
  v1::Scene scene = mix_scenes(keys[first], keys[first + 1], part * part * (3 - 2 * part));
  set_pose(*scene.mutable_camera(), on_curve({before, a, b, after}, part));
  return scene;
}

Result<void> check_video(const v1::Video& video, const std::vector<v1::Scene>& keys,
                         std::uint32_t phases) {
  if (video.frames_per_second() < 10 || video.frames_per_second() > 60) {
    return fail(ErrorCode::kInvalid, "A video must have 10 to 60 frames per second.",
                "framesPerSecond");
  }
  if (video.frames() < 2 || video.frames() > kLongestVideoSeconds * video.frames_per_second()) {
    return fail(ErrorCode::kInvalid, "A video must have at least 2 frames and last at most 60 s.",
                "frames");
  }
  if (const auto sound = check_side(video.width(), "width"); !sound) return sound;
  if (const auto sound = check_side(video.height(), "height"); !sound) return sound;
  if (!(video.error() >= kLeastFileError && video.error() <= 1)) {
    return fail(ErrorCode::kInvalid, "The error of a frame must be between 0.005 and 1.", "error");
  }
  const bool tour = video.path() == v1::Video::TOUR;
  if (!tour && video.path() != v1::Video::TURNTABLE && video.path() != v1::Video::STANDING) {
    return fail(ErrorCode::kInvalid, "This kind of video is not supported.", "path");
  }
  if (const auto sound = check_phases(video, phases); !sound) return sound;
  if (keys.size() < (tour ? 2u : 1u) || keys.size() > kMostKeyViews) {
    return fail(ErrorCode::kInvalid,
                tour ? "A tour must have 2 to 16 views." : "The view is missing.", "keys");
  }
  for (const v1::Scene& key : keys) {
    if (const auto sound = check_scene(key); !sound) return sound;
  }
  return {};
}

v1::Scene video_frame(const v1::Video& video, const std::vector<v1::Scene>& keys,
                      std::uint32_t index, std::uint32_t phases) {
  v1::Scene scene = view_at(video, keys, index);
  if (video.phase_cycles() == 0) return scene;
  const std::uint64_t step = std::uint64_t{index} * video.phase_cycles() * phases / video.frames();
  scene.set_volume_phase(static_cast<std::uint32_t>(step % phases));
  return scene;
}

}  // namespace diaphane::render
