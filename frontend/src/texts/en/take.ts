import { count, number } from "./counting";

/** Exports: pictures, videos and links to the current view. */
export const take = {
  title: "Save or share",
  file: "Save a file",
  what: "File type",
  kinds: { picture: "Picture", turntable: "Video of a full rotation", tour: "Video tour of saved presets" },
  picture: "Save a picture",
  pictureLead:
    "We render the picture again at the size you choose. You can carry on in the meantime. The file contains only the picture: no name, no date and nothing that says which scan it comes from.",
  pictureNow:
    "This saves the picture at once, exactly as you see it. The file contains only the picture: no name, no date and nothing that says which scan it comes from.",
  size: "Size",
  sizes: {
    screen: (width: number, height: number) => `As it is on the screen now, ${width} × ${height}`,
    large: (width: number, height: number) => `Large, ${width} × ${height}`,
    largest: (width: number, height: number) => `Very large, ${width} × ${height}`,
    poster: (width: number, height: number) => `Poster, ${width} × ${height} (takes a long time)`,
    other: "Custom",
  },
  width: "Width",
  height: "Height",
  wrongSize: (least: number, most: number) =>
    `Each side must be between ${least} and ${number.format(most)} pixels. Enter whole numbers.`,
  otherHint: "The vertical field of view stays the same. The sides are cropped or extended.",
  quality: "Quality",
  qualities: {
    quick: "Draft, a little grainy",
    good: "Good, hardly any grain",
    best: "Finished (takes the longest)",
  },
  timeHint: "This uses your rendering time.",
  save: "Save the picture",
  ofPicture: {
    rendering: "Rendering the picture",
    saved: "The picture has been saved.",
    stopped: "No picture was saved.",
    failed: "The picture couldn’t be rendered. Try again.",
  },
  ofVideo: {
    rendering: "Rendering the video",
    saved: "The video has been saved.",
    stopped: "No video was saved.",
    failed: "The video couldn’t be rendered. Try again.",
  },
  busy: "The server is busy with other people’s files. Try again in a few minutes.",
  hide: "Hide this message",
  turntableLead:
    "What you see now, rotated once about the body’s long axis. The video loops seamlessly. The file contains only the pictures: no name, no date and nothing that says which scan they come from.",
  tourLead:
    "A smooth transition from one saved preset to the next: viewpoint, colours and lights change gradually. The file contains only the pictures: no name, no date and nothing that says which scan they come from.",
  seconds: "Length in seconds",
  rate: "Frames per second",
  videoSizes: {
    small: (width: number, height: number) => `Small, ${width} × ${height}`,
    medium: (width: number, height: number) => `Medium, ${width} × ${height}`,
    large: (width: number, height: number) => `Large, ${width} × ${height}`,
  },
  videoHint: (frames: number) =>
    frames > 0
      ? `We’ll render ${count(frames, "picture", "pictures")} for this video. This uses your rendering time.`
      : "This uses your rendering time.",
  videoTime: (seconds: number | null) =>
    seconds === null
      ? "As soon as the picture is sharper, we can say here how long it will take."
      : seconds < 50
        ? "It takes less than a minute, and longer while somebody turns a picture."
        : seconds < 3300
          ? `It takes about ${count(Math.round(seconds / 60), "minute", "minutes")}, and longer while somebody turns a picture.`
          : `It takes about ${count(Math.round(seconds / 3600), "hour", "hours")}, and longer while somebody turns a picture.`,
  wrongSeconds: (most: number) => `Enter a whole number of seconds between 1 and ${most}.`,
  views: "Views, in this order",
  viewNow: "Current view",
  noViews:
    "There are no saved presets for this scan yet. Save a few with the star button at the top, one for each view that the tour should show.",
  wrongViews: (most: number) => `Choose between 2 and ${most} views for the tour.`,
  earlier: "Move up",
  earlierOf: (name: string) => `Move ${name} up`,
  saveVideo: "Save the video",
  link: "Share a link to this view",
  linkLead:
    "Anyone who already has access to this scan sees it as it is now, with your colours, lights, cuts and viewpoint. The link doesn’t give anyone else access to the scan. It contains the names of your lights and materials, but not the patient’s name.",
  linkWithoutPatterns: "The link doesn’t keep your own pictures as light patterns.",
  linkField: "Link",
  linkTooLarge: "This view has too many details for a link. Save it as a preset instead.",
  copy: "Copy",
  copied: "Copied.",
  notCopied: "The link couldn’t be copied. Select it and copy it yourself.",
  linkDamaged: "This link is damaged or incomplete, so the scan is shown as usual.",
  linkNewer:
    "This link comes from a newer version of Diaphane, so the scan is shown as usual. Reload the page and try again.",
} as const;
