"""Draws bone with VTK's volume mapper, which ParaView uses, for the comparison in docs/gallery.md.

    pip install vtk==9.7.2 pydicom==3.0.1 numpy
    ./diaphane sample --write-dicom FOLDER
    python bench/peers/vtk_picture.py FOLDER OUT.png [--shadows]
"""

from __future__ import annotations

import argparse
import math
from pathlib import Path

import numpy as np
import pydicom
import vtk
from vtk.util.numpy_support import numpy_to_vtk

#: The two materials of the look "bone" as one: Hounsfield units, colour and opacity, with 2.5 per mm for an opacity of 1.
CURVE = ((140, (0.90, 0.79, 0.60), 0.0), (260, (0.90, 0.79, 0.60), 0.35), (500, (0.92, 0.84, 0.70), 0.9), (900, (0.95, 0.90, 0.80), 1.0))
EXTINCTION_PER_MM = 2.5
#: The direction from the middle to the camera, in the patient's axes (left, posterior, superior).
TOWARDS_EYE = np.array([0.5, -1, 0.2])


def image(folder: Path) -> vtk.vtkImageData:
    slices = sorted((pydicom.dcmread(file) for file in folder.iterdir()), key=lambda one: float(one.ImagePositionPatient[2]))
    values = np.stack([one.pixel_array * float(one.RescaleSlope) + float(one.RescaleIntercept) for one in slices]).astype(np.int16)
    apart = float(slices[1].ImagePositionPatient[2]) - float(slices[0].ImagePositionPatient[2])
    made = vtk.vtkImageData()
    made.SetDimensions(values.shape[::-1])
    made.SetSpacing(*map(float, reversed(slices[0].PixelSpacing)), apart)
    made.GetPointData().SetScalars(numpy_to_vtk(values.ravel(), deep=True))
    return made


def bone(data: vtk.vtkImageData, shadows: bool) -> vtk.vtkVolume:
    mapper = vtk.vtkGPUVolumeRayCastMapper()
    mapper.SetInputData(data)
    mapper.SetAutoAdjustSampleDistances(False)
    mapper.SetSampleDistance(0.3)
    mapper.SetUseJittering(True)
    mapper.SetGlobalIlluminationReach(float(shadows))
    mapper.SetVolumetricScatteringBlending(float(shadows))
    colour, opacity = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
    for value, rgb, share in CURVE:
        colour.AddRGBPoint(value, *rgb)
        opacity.AddPoint(value, 1 - math.exp(-EXTINCTION_PER_MM * share))
    matter = vtk.vtkVolumeProperty()
    matter.SetColor(colour)
    matter.SetScalarOpacity(opacity)
    matter.SetInterpolationTypeToLinear()
    matter.ShadeOn()
    matter.SetSpecular(0.2)
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper)
    volume.SetProperty(matter)
    return volume


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--shadows", action="store_true", help="with volumetric shadows")
    options = parser.parse_args()
    data = image(options.folder)
    renderer = vtk.vtkRenderer()
    renderer.AddVolume(bone(data, options.shadows))
    renderer.SetBackground(0.16, 0.17, 0.19)
    camera, middle = renderer.GetActiveCamera(), np.array(data.GetCenter())
    camera.SetFocalPoint(middle)
    camera.SetPosition(middle + 560 * TOWARDS_EYE / np.linalg.norm(TOWARDS_EYE))
    camera.SetViewUp(0, 0, 1)
    camera.SetViewAngle(25)
    renderer.ResetCameraClippingRange()
    key = vtk.vtkLight()
    key.SetLightTypeToCameraLight()
    key.SetPosition(-1, 1.2, 1)
    key.SetIntensity(1.3)
    fill = vtk.vtkLight()
    fill.SetLightTypeToHeadlight()
    fill.SetIntensity(0.3)
    renderer.AutomaticLightCreationOff()
    renderer.AddLight(key)
    renderer.AddLight(fill)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetSize(480, 360)
    window.AddRenderer(renderer)
    window.Render()
    pixels = vtk.vtkWindowToImageFilter()
    pixels.SetInput(window)
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(str(options.out))
    writer.SetInputConnection(pixels.GetOutputPort())
    writer.Write()


if __name__ == "__main__":
    main()
