#pragma once

#include <optional>
#include <string>

namespace diaphane::render {

enum class H264Device {
  kX264,   ///< on the CPU
  kNvenc,  ///< on an NVIDIA GPU's encoder; the large ones for computing (H100, H200) have none
};

/// What is known of this process's encoders.
struct H264Probe {
  bool x264 = false;          ///< FFmpeg has it
  bool nvenc = false;         ///< a session opened and coded a frame
  std::string nvenc_why_not;  ///< empty when it did
};

/// NVENC when it really works, else x264, else nothing. Pure.
std::optional<H264Device> choose_h264(const H264Probe& probe);

/// Tries each encoder with a real frame, once a process, and logs what it found.
const H264Probe& h264_probe();

}  // namespace diaphane::render
