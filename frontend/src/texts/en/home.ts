/** The front page for people who are not signed in. */
export const home = {
  title: "See your own scan in 3D",
  what: "Diaphane turns the CT or MR scan on the disc from your hospital into a 3D picture that you can turn and view from every side, here in your browser.",
  privacy:
    "The patient’s name is removed before anything is uploaded, and only you can see your scans unless you share them.",
  notMedical: "Diaphane is not a medical device and makes no diagnosis. Please talk to your doctor about what you see.",
  sample: "View a sample scan",
  others: "More samples",
  open: (title: string) => `View the sample “${title}”`,
} as const;
