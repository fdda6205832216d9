/** Anonymising a scan by cutting parts of it away. */
export const cut = {
  title: "Anonymise this scan",
  head: "This scan shows a head. A face can be recognised from a scan just as from a photograph. The slanted cut removes the face. Turn the picture and check that nothing of the face is left.",
  noHead:
    "We didn’t find a head in this scan, but we could be wrong. Look at the picture from all sides. Can you see a face, or anything else that could identify someone?",
  noIdea: "Look at the picture from all sides. Can you see a face, or anything else that could identify someone?",
  how: "Drag the round handles in the picture, or move the sliders. What you cut away is deleted once you confirm.",
  area: "Box in the picture",
  panel: "Part to keep",
  facePlane: "Slanted cut to remove the face",
  plane: "Slanted cut: position",
  tilt: "Slanted cut: tilt",
  aside: "Slanted cut: sideways rotation",
  faces: {
    x: { low: "Right side", high: "Left side" },
    y: { low: "Front", high: "Back" },
    z: { low: "Bottom", high: "Top" },
  },
  mm: (value: number) => `${value} mm`.replace("-", "−"),
  degrees: (value: number) => `${value}°`.replace("-", "−"),
  goes: (percent: number) =>
    percent === 0 ? "You haven’t cut anything away yet." : `${percent}% of the scan will be deleted.`,
  keepAll: "Keep everything",
  propose: "Use the suggested cut",
  confirmCut: "Cut permanently…",
  leave: "Cancel",
  confirmTitle: "This can’t be undone",
  confirmLead:
    "What you cut away will be permanently deleted from our disks: from the scan itself, from every picture made of it, and for everyone who is looking at it now. Nobody can restore it, neither you nor we. Your disc at home stays as it is.",
  confirmMarks:
    "Marks and measurements that were saved with this scan, also in presets, will be deleted because their texts may name someone.",
  confirmNothing:
    "You haven’t cut anything away. The whole scan stays as it is, and once you confirm, you can make it public.",
  confirmAfter:
    "You can add the scan to the gallery only after this step. It isn’t added until you do so. Everyone with an account then also sees its title, its description and the names of its presets.",
  understood: "I have looked at it from all sides, and I understand that this can’t be undone.",
  confirm: "Cut permanently",
  working: "Cutting the scan. This takes a few seconds.",
  doneTitle: "The cut is finished",
  done: "What you cut away has been permanently deleted.",
  donePrivate: "The scan is still private.",
  doneShared: "The scan is not in the gallery, but the people and links that you shared it with can still open it.",
  look: "View and share the scan",
  failed: "The scan couldn’t be cut, and nothing has been changed. Try again.",
  back: "Back to my scans",
} as const;
