#pragma once
// Empty, because NVRTC has these declarations built in.
