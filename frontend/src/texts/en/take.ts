import { count, number } from "./counting";
import { scans } from "./scans";

const minutes = (seconds: number) => count(Math.max(1, Math.round(seconds / 60)), "minute", "minutes");
const hours = (seconds: number) => count(Math.round(seconds / 3600), "hour", "hours");

/** Returns a duration in words that lies between two numbers of seconds. */
function between(least: number, most: number): string {
  if (most < 50) return "less than a minute";
  const last = most < 5400 ? minutes(most) : hours(most);
  if (least < 50) return `up to ${last}`;
  const first = least < 5400 ? minutes(least) : hours(least);
  if (first === last) return `about ${last}`;
  const alike = least < 5400 === most < 5400; // "4 to 12 minutes" says the unit once
  return `about ${alike ? first.split(" ")[0] : first} to ${last}`;
}

/** Exports: pictures, videos and links to the current view. */
export const take = {
  title: "Save or share",
  file: "Save a file",
  what: "File type",
  kinds: {
    picture: "Picture",
    turntable: "Video of a full rotation",
    around: "Video of “Show me around”",
    tour: "Video tour of saved presets",
    phases: "Video of the phases",
  },
  picture: "Save a picture",
  pictureLead:
    "We render the picture again at the size you choose. You can carry on in the meantime. The file contains only the picture: no name, no date and nothing that says which scan it comes from.",
  pictureNow:
    "This saves the picture at once, exactly as you see it. The file contains only the picture: no name, no date and nothing that says which scan it comes from.",
  onlyScreen: "You can’t save videos or larger pictures of this scan. Only its owner can allow this.",
  size: "Size",
  sizes: {
    screen: (width: number, height: number) => `As shown, ${width} × ${height}`,
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
  timeHint: "This uses rendering time.",
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
  aroundLead:
    "What you see now, in one slow turn through the views that show most of it. The file contains only the pictures: no name, no date and nothing that says which scan they come from.",
  phasesLead:
    "What you see now, while the phases of the scan are played. The video loops seamlessly. The file contains only the pictures: no name, no date and nothing that says which scan they come from.",
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
      ? `We’ll render ${count(frames, "picture", "pictures")} for this video. This uses rendering time.`
      : "This uses rendering time.",
  videoTime: (time: { readonly least: number; readonly most: number } | null) =>
    time === null
      ? "As soon as the picture is sharper, we can say here how long it will take."
      : `It takes ${between(time.least, time.most)}, and longer while somebody turns a picture. While it is being made, you can see how much time is left.`,
  framesBegun: (done: number, all: number) =>
    done === 0 ? `The first of ${count(all, "picture", "pictures")} is being rendered.` : `${done} of ${all}`,
  framesDone: (done: number, all: number, left: number) => `${done} of ${all}, ${scans.upload.left(left)}`,
  wrongSeconds: (least: number, most: number) => `Enter a whole number of seconds between ${least} and ${most}.`,
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
