import type { studyTemplates as english } from "../en/study_templates";
import type { Translation } from "../shape";

/** Die ersten Texte einer neuen Studie. */
export const studyTemplates: Translation<typeof english> = {
  titles: {
    comfort: "Wie angenehm ist das Bild?",
    validation: "Welches Bild ist am angenehmsten?",
    viewpoints: "Wählen Sie die beste Ansicht",
    latency: "Wie schnell reagiert das Bild?",
    sus: "Wie gut lässt sich dieses Programm bedienen?",
    own: "Neue Studie",
  },
  consent:
    "Wir laden Sie ein, an einer Studie teilzunehmen. Die Teilnahme ist freiwillig. Sie brauchen kein Konto, und wir speichern weder Ihren Namen noch Ihre Adresse. Wir speichern nur Ihre Antworten und wie lange jeder Schritt gedauert hat, ob Sie fertig geworden sind, die Sprache und den Tag und, wenn Sie zustimmen, die Aufzeichnung.\n\nSie können jederzeit ohne Angabe von Gründen aufhören. Am Ende erhalten Sie einen Link, mit dem Sie Ihre Antworten später löschen können.\n\nEinige Bilder zeigen das Innere eines menschlichen Körpers.\n\n[Beschreiben Sie den Zweck Ihrer Studie, wie lange sie dauert, wie lange Sie die Antworten aufbewahren und an wen sich Teilnehmende wenden können.]",
  instructions: "[Schreiben Sie hier, was Teilnehmende wissen oder tun sollen.]",
  remarks: "Möchten Sie noch etwas anmerken? Sie können das Feld leer lassen.",
  rating: "Sehen Sie sich das Bild zuerst von allen Seiten an. Wie angenehm ist es für Sie, dieses Bild anzusehen?",
  ratingLow: "sehr unangenehm",
  ratingHigh: "sehr angenehm",
  colours: "Ändern Sie die Farben so, dass das Bild für Sie angenehmer wird.",
  order: "Ordnen Sie die Bilder vom unangenehmsten bis zum angenehmsten.",
  viewpoint: "Drehen Sie das Bild, bis Sie den farbigen Teil möglichst gut sehen.",
  latency: "Drehen Sie das Bild so schnell und so genau wie möglich, bis der farbige Teil zu Ihnen zeigt.",
  susLow: "stimme gar nicht zu",
  susHigh: "stimme voll zu",
  sus: [
    "Ich kann mir sehr gut vorstellen, das System regelmäßig zu nutzen.",
    "Ich empfinde das System als unnötig komplex.",
    "Ich empfinde das System als einfach zu nutzen.",
    "Ich denke, dass ich technischen Support brauchen würde, um das System zu nutzen.",
    "Ich finde, dass die verschiedenen Funktionen des Systems gut integriert sind.",
    "Ich finde, dass es im System zu viele Inkonsistenzen gibt.",
    "Ich kann mir vorstellen, dass die meisten Leute das System schnell zu beherrschen lernen.",
    "Ich empfinde die Bedienung als sehr umständlich.",
    "Ich habe mich bei der Nutzung des Systems sehr sicher gefühlt.",
    "Ich musste eine Menge Dinge lernen, bevor ich mit dem System arbeiten konnte.",
  ],
};
