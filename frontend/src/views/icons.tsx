/**
 * Line icons in a box of 24 by 24. They are decorative, because a label or a text next to them
 * states their meaning.
 */
const paths = {
  back: "M15 5l-7 7 7 7",
  plus: "M12 5v14M5 12h14",
  pencil: "M4 20l1-4L16.500 4.500l3 3L8 19zM14 7l3 3",
  tag: "M4 4h8l8.5 8.5-8 8L4 12zM8.200 7a1.200 1.200 0 100 2.400 1.200 1.200 0 000-2.400z",
  trash: "M4 7h16M10 11v6M14 11v6M6 7l1 13h10l1-13M9 7V4h6v3",
  sun: "M12 8a4 4 0 100 8 4 4 0 000-8zM12 2v2.5M12 19.5V22M4.9 4.9l1.8 1.8M17.3 17.3l1.8 1.8M2 12h2.5M19.5 12H22M4.9 19.1l1.8-1.8M17.3 6.7l1.8-1.8",
  moon: "M20 14.5A8.5 8.5 0 119.5 4a7 7 0 0010.5 10.5z",
  ruler: "M4 17L17 4l3 3L7 20zM8 13l2 2M11 10l2 2M14 7l2 2",
  angle: "M20 19H4L14 5M11 19a8 8 0 00-3-5",
  level: "M3 17h18M5 12L18 5M15 4l3.500 1-1 3.500",
  reset: "M4 12a8 8 0 108-8H7M10 1L7 4l3 3",
  fullscreen: "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5",
  camera: "M4 8h3.5L9 5.5h6L16.5 8H20v11H4zM12 10a3.5 3.5 0 100 7 3.5 3.5 0 000-7z",
  help: "M12 3a9 9 0 100 18 9 9 0 000-18zM9.5 9.5a2.5 2.5 0 113.6 2.2c-.8.4-1.1.9-1.1 1.8M12 16.6v.3",
  chart: "M4 4v16h16M7 8c2 6 5 8 12 9",
  close: "M6 6l12 12M18 6L6 18",
  folder: "M3 6.5h6.5l2 2.5H21v10.5H3zM12 12v5M9.5 14.5h5",
  shield: "M12 3l7.5 3v5.5c0 4.5-3 8-7.5 9.5-4.5-1.5-7.5-5-7.5-9.5V6zM9 12l2.2 2.2L15.5 10",
  alert: "M12 4l9 16H3zM12 10v4.5M12 17.3v.2",
  upload: "M12 16V4M7 9l5-5 5 5M4 15v5h16v-5",
  clock: "M12 3a9 9 0 100 18 9 9 0 000-18zM12 7.500v5l3.200 2",
  check: "M5 12.5l4.5 4.5L19 7.5",
  mail: "M3 6h18v12.5H3zM3 7l9 6.5L21 7",
  eye: "M2.5 12S6 5.5 12 5.5 21.5 12 21.5 12 18 18.5 12 18.5 2.5 12 2.5 12zM12 9a3 3 0 100 6 3 3 0 000-6z",
  eye_off:
    "M4 4l16 16M9.5 6A9.8 9.8 0 0112 5.5c6 0 9.5 6.5 9.5 6.5a17 17 0 01-2.9 3.6M6.2 7.9A16 16 0 002.5 12S6 18.5 12 18.5c1.6 0 3-.4 4.2-1M10 10a3 3 0 004 4",
  people:
    "M9 5a3.5 3.5 0 100 7 3.5 3.5 0 000-7zM2.5 19.5c.5-3.5 3-5.5 6.5-5.5s6 2 6.5 5.5M16 5.3a3.5 3.5 0 010 6.4M18 14.5c2 .7 3.2 2.500 3.5 5",
  person: "M12 4a4 4 0 100 8 4 4 0 000-8zM4.5 20c.6-3.800 3.500-6 7.500-6s6.900 2.200 7.500 6",
  record: "M12 4a8 8 0 100 16 8 8 0 000-16zM12 9a3 3 0 100 6 3 3 0 000-6z",
  copy: "M8 8h12v12H8zM16 8V4H4v12h4",
  flag: "M6 21V4M6 4.5h11l-2.5 4 2.500 4H6",
  up: "M12 19V6M6 11.500l6-6 6 6",
  down: "M12 5v13M6 12.500l6 6 6-6",
  star: "M12 4l2.5 5.200 5.700.7-4.200 3.900 1.100 5.600-5.100-2.800-5.100 2.800 1.100-5.600L3.800 9.900l5.700-.7z",
  globe:
    "M12 3a9 9 0 100 18 9 9 0 000-18zM3 12h18M12 3c3 3 3.500 6 3.500 9s-.5 6-3.500 9c-3-3-3.500-6-3.500-9s.5-6 3.500-9z",
  undo: "M8 5L4 9l4 4M4 9h10a5.500 5.500 0 010 11h-3",
  redo: "M16 5l4 4-4 4M20 9H10a5.500 5.500 0 000 11h3",
  palette: "M4 20V9M4 20h16M4 18c4 0 4-11 8-11s4 8 8 8",
  lamp: "M12 3a6 6 0 00-3.500 10.900V16h7v-2.100A6 6 0 0012 3zM9.500 19h5M10.500 21.500h3",
  aperture:
    "M12 3a9 9 0 100 18 9 9 0 000-18zM14.500 9L20 8M9.500 15L4 16M15 13.500l2.500 5.500M9 10.500L6.500 5M11 15.500l-2 5M13 8.500l2-5",
  slice: "M4 8l8-4 8 4-8 4zM4 12l8 4 8-4M4 16l8 4 8-4",
  compare: "M4 5h7v14H4zM13 5h7v14h-7z",
  swap: "M7 5L3 9l4 4M3 9h12M17 11l4 4-4 4M21 15H9",
  four: "M4 4h7v7H4zM13 4h7v7h-7zM4 13h7v7H4zM13 13h7v7h-7z",
  grip: "M12 4v16M4 12h16M12 4l-2.500 2.500M12 4l2.500 2.500M12 20l-2.500-2.500M12 20l2.500-2.500M4 12l2.500-2.500M4 12l2.500 2.500M20 12l-2.500-2.500M20 12l-2.500 2.500",
  dock: "M4 5h16v14H4zM10 5v14M16.500 9.500L14 12l2.500 2.500",
  arrow: "M19 19L6 6M6 14V6h8",
  ring: "M12 5a7 7 0 100 14 7 7 0 000-14z",
  letter: "M5 7V5h14v2M12 5v14M9 19h6",
  hand: "M8 12V5.5a1.500 1.500 0 013 0V11M11 11V4.500a1.500 1.500 0 013 0V11M14 11V6a1.500 1.500 0 013 0v8c0 4-2.500 6.500-6 6.500-3 0-4.500-1.500-6-4.500l-1.500-3a1.500 1.500 0 012.500-1.500L8 13",
  left: "M15 5l-7 7 7 7",
  right: "M9 5l7 7-7 7",
  play: "M8 5l11 7-11 7z",
  pause: "M8 5v14M16 5v14",
  repeat: "M17 3l3 3-3 3M4 11V9a3 3 0 013-3h13M7 21l-3-3 3-3M20 13v2a3 3 0 01-3 3H4",
  out: "M14 4h6v16h-6M3 12h11M10 8l4 4-4 4",
} as const;

export type IconName = keyof typeof paths;

export function Icon({ name }: { readonly name: IconName }) {
  return (
    <svg class="icon" viewBox="0 0 24 24" aria-hidden="true" focusable="false">
      <path d={paths[name]} />
    </svg>
  );
}

/** Slices of a head, one behind the other. The nearest is the most opaque. */
export function Mark() {
  return (
    <svg class="mark" viewBox="0 0 32 32" aria-hidden="true" focusable="false">
      <ellipse cx="16" cy="9" rx="7" ry="3.4" class="mark-3" />
      <ellipse cx="16" cy="16" rx="11" ry="5" class="mark-2" />
      <ellipse cx="16" cy="22.5" rx="9" ry="4.2" class="mark-1" />
    </svg>
  );
}
