/** The first texts of a new study, which the researcher can change. Loaded in both languages at the same time. */
export const studyTemplates = {
  titles: {
    comfort: "How comfortable is the picture?",
    validation: "Which picture is the most comfortable?",
    viewpoints: "Choose the best view",
    latency: "How quickly does the picture respond?",
    sus: "How usable is this program?",
    own: "New study",
  },
  consent:
    "You are invited to take part in a study. Taking part is voluntary. You need no account, and we store neither your name nor your address. We store only your answers and how long each step took, whether you finished, the language and the day, and, if you agree, the recording.\n\nYou can stop at any time without giving a reason. At the end you receive a link with which you can delete your answers later.\n\nSome pictures show the inside of a human body.\n\n[Describe the purpose of your study, how long it takes, how long you keep the answers, and whom participants can contact.]",
  instructions: "[Write what participants should know or do here.]",
  remarks: "Do you have any remarks? You can leave this empty.",
  rating: "Look at the picture from all sides first. How comfortable do you feel when you look at it?",
  ratingLow: "very uncomfortable",
  ratingHigh: "very comfortable",
  colours: "Change the colours so that the picture becomes more comfortable for you.",
  order: "Put the pictures in order, from the least comfortable to the most comfortable one.",
  viewpoint: "Turn the picture until you see the coloured part as well as possible.",
  latency: "Turn the picture so that the coloured part faces you, as quickly and as precisely as you can.",
  susLow: "strongly disagree",
  susHigh: "strongly agree",
  /** The System Usability Scale (Brooke, 1996). */
  sus: [
    "I think that I would like to use this system frequently.",
    "I found the system unnecessarily complex.",
    "I thought the system was easy to use.",
    "I think that I would need the support of a technical person to be able to use this system.",
    "I found the various functions in this system were well integrated.",
    "I thought there was too much inconsistency in this system.",
    "I would imagine that most people would learn to use this system very quickly.",
    "I found the system very cumbersome to use.",
    "I felt very confident using the system.",
    "I needed to learn a lot of things before I could get going with this system.",
  ],
} as const;
