#include "tasks/common/recall_paraphrases.h"

namespace engram {
namespace {

constexpr ParaphraseSet kRecallSets[] = {
    {"Observe the cube's color, wait, then touch the cube of the same color.",
     {"Look at the color of the cube, wait, and then touch the cube that has the same color.",
      "Remember the cube's color. After waiting, touch the cube of that color.",
      "Watch which color the cube has, wait, and touch the cube in the same color.",
      "Note the color of the cube, wait, then put the gripper on the cube of the same color.",
      "First see what color the cube is; then wait; then touch the cube with that color.",
      "Keep the cube's color in mind, wait, and afterwards touch the cube whose color is the same.",
      "You see a cube. Remember its color, wait, and touch the cube of the same color.",
      "Memorize the color of the cube, wait, then touch the one with the same color.",
      "After you have seen the cube's color, wait and then touch the cube that matches it.",
      "Touch the cube of the same color as the cube that you observe before waiting."}},
    {"Observe the object's shape, wait, then touch the object of the same shape.",
     {"Look at the shape of the object, wait, and then touch the object that has the same shape.",
      "Remember the object's shape. After waiting, touch the object of that shape.",
      "Watch which shape the object has, wait, and touch the object with the same shape.",
      "Note the shape of the object, wait, then put the gripper on the object of the same shape.",
      "First see what shape the object is; then wait; then touch the object with that shape.",
      "Keep the object's shape in mind, wait, and afterwards touch the object whose shape is the "
      "same.",
      "You see an object. Remember its shape, wait, and touch the object of the same shape.",
      "Memorize the shape of the object, wait, then touch the one with the same shape.",
      "After you have seen the object's shape, wait and then touch the object that matches it.",
      "Touch the object of the same shape as the object that you observe before waiting."}},
    {"Observe the object's shape and color, wait, then touch the object of the same shape and "
     "color.",
     {"Look at the shape and color of the object, wait, and then touch the object that has both.",
      "Remember the object's shape and color. After waiting, touch the object of that shape and "
      "color.",
      "Watch which shape and color the object has, wait, and touch the object with the same shape "
      "and color.",
      "Note the color and the shape of the object, wait, then touch the object of the same color "
      "and shape.",
      "First see what shape and color the object has; then wait; then touch the object with both.",
      "Keep the object's shape and color in mind, wait, and afterwards touch the object with the "
      "same ones.",
      "You see an object. Remember its shape and color, wait, and touch the object that has the "
      "same.",
      "Memorize shape and color of the object, wait, then touch the one with the same shape and "
      "color.",
      "After you have seen the object's shape and color, wait and then touch the object that "
      "matches both.",
      "Touch the object of the same shape and color as the object that you observe before "
      "waiting."}},
    {"Observe the cubes shown, wait, then touch the cube whose color was not present before.",
     {"Look at the cubes that are shown, wait, and then touch the cube with a color that was not "
      "there before.",
      "Remember the colors of the cubes shown. After waiting, touch the cube of the color that was "
      "missing.",
      "Watch the cubes, wait, and touch the cube whose color you have not seen before.",
      "Note which colors are shown, wait, then touch the cube in the color that was not among "
      "them.",
      "First see the cubes; then wait; then touch the cube with the color that is new.",
      "Keep the colors of the cubes in mind, wait, and touch the cube whose color was absent.",
      "You see some cubes. Remember their colors, wait, and touch the cube of another color.",
      "Memorize the cubes shown, wait, then touch the one whose color was not present.",
      "After you have seen the cubes, wait and then touch the cube whose color did not appear.",
      "Touch the cube whose color was not present among the cubes shown before waiting."}},
    {"Observe the shapes shown, wait, then touch the object whose shape was not present before.",
     {"Look at the shapes that are shown, wait, and then touch the object with a shape that was "
      "not there before.",
      "Remember the shapes shown. After waiting, touch the object of the shape that was missing.",
      "Watch the shapes, wait, and touch the object whose shape you have not seen before.",
      "Note which shapes are shown, wait, then touch the object with the shape that was not among "
      "them.",
      "First see the shapes; then wait; then touch the object with the shape that is new.",
      "Keep the shapes in mind, wait, and touch the object whose shape was absent.",
      "You see some shapes. Remember them, wait, and touch the object of another shape.",
      "Memorize the shapes shown, wait, then touch the object whose shape was not present.",
      "After you have seen the shapes, wait and then touch the object whose shape did not appear.",
      "Touch the object whose shape was not present among the shapes shown before waiting."}},
    {"Observe the objects shown, wait, then touch the object whose shape and color combination was "
     "not present before.",
     {"Look at the objects that are shown, wait, and then touch the object whose combination of "
      "shape and color was not there before.",
      "Remember shapes and colors of the objects shown. After waiting, touch the object with the "
      "combination that was missing.",
      "Watch the objects, wait, and touch the object whose shape and color you have not seen "
      "together before.",
      "Note which combinations of shape and color are shown, wait, then touch the object that was "
      "not among them.",
      "First see the objects; then wait; then touch the object with the combination of shape and "
      "color that is new.",
      "Keep the objects in mind, wait, and touch the object whose combination of color and shape "
      "was absent.",
      "You see some objects. Remember shape and color of each, wait, and touch the object with "
      "another combination.",
      "Memorize the objects shown, wait, then touch the one whose shape and color combination was "
      "not present.",
      "After you have seen the objects, wait and then touch the object whose combination of shape "
      "and color did not appear.",
      "Touch the object whose shape and color combination was not present among the objects shown "
      "before waiting."}},
    {"Observe which cup hides the ball, wait, then touch that cup.",
     {"Look which cup hides the ball, wait, and then touch this cup.",
      "Remember the cup that hides the ball. After waiting, touch it.",
      "Watch under which cup the ball is, wait, and touch that cup.",
      "Note the cup that the ball is hidden by, wait, then put the gripper on that cup.",
      "First see which cup hides the ball; then wait; then touch the cup.",
      "Keep in mind which cup hides the ball, wait, and afterwards touch it.",
      "A cup hides the ball. Remember which one, wait, and touch it.",
      "Memorize which cup the ball is under, wait, then touch this cup.",
      "After you have seen which cup hides the ball, wait and then touch that one.",
      "Touch the cup that hides the ball, after you have observed which one it is and waited."}},
    {"Observe which cup hides the ball, wait, then push that cup forward.",
     {"Look which cup hides the ball, wait, and then push this cup forward.",
      "Remember the cup that hides the ball. After waiting, push it forward.",
      "Watch under which cup the ball is, wait, and push that cup forward.",
      "Note the cup that the ball is hidden by, wait, then push that cup to the front.",
      "First see which cup hides the ball; then wait; then push the cup forward.",
      "Keep in mind which cup hides the ball, wait, and afterwards push it forward.",
      "A cup hides the ball. Remember which one, wait, and push it forward.",
      "Memorize which cup the ball is under, wait, then push this cup forward.",
      "After you have seen which cup hides the ball, wait and then push that one forward.",
      "Push forward the cup that hides the ball, after you have observed which one it is and "
      "waited."}},
    {"Observe which cup hides the ball, wait, then pick up that cup and lift it.",
     {"Look which cup hides the ball, wait, and then pick up this cup and lift it.",
      "Remember the cup that hides the ball. After waiting, pick it up and lift it.",
      "Watch under which cup the ball is, wait, and pick up and lift that cup.",
      "Note the cup that the ball is hidden by, wait, then take that cup and lift it up.",
      "First see which cup hides the ball; then wait; then grasp the cup and lift it.",
      "Keep in mind which cup hides the ball, wait, and afterwards pick it up and lift it.",
      "A cup hides the ball. Remember which one, wait, pick it up and lift it.",
      "Memorize which cup the ball is under, wait, then pick this cup up and lift it.",
      "After you have seen which cup hides the ball, wait, then pick up that one and lift it.",
      "Pick up and lift the cup that hides the ball, after you have observed which one it is and "
      "waited."}},
    {"Observe which color is under each cup, then touch the cup matching the lamp color.",
     {"Look which color is under each cup, and then touch the cup that matches the lamp's color.",
      "Remember the color under every cup. Then touch the cup with the color of the lamp.",
      "Watch which color each cup has under it, then touch the one that fits the lamp's color.",
      "Note the colors under the cups, then touch the cup whose color the lamp has.",
      "First see which color is under each cup; then touch the cup with the lamp's color.",
      "Keep the color under each cup in mind, and touch the cup matching the color of the lamp.",
      "There is a color under each cup. Remember them, and touch the cup that matches the lamp "
      "color.",
      "Memorize which color is under which cup, then touch the cup of the lamp's color.",
      "After you have seen the color under each cup, touch the cup that the lamp's color belongs "
      "to.",
      "Touch the cup matching the lamp color, after you have observed which color is under each "
      "cup."}},
    {"Observe which cup hides the ball, track the cups as they shuffle, then touch the correct "
     "cup.",
     {"Look which cup hides the ball, follow the cups while they are shuffled, and then touch the "
      "correct cup.",
      "Remember the cup that hides the ball. Track the cups through the shuffle, then touch the "
      "correct one.",
      "Watch under which cup the ball is, keep track of the cups as they move, and touch the cup "
      "with the ball.",
      "Note the cup that hides the ball, follow it through the shuffle, then touch it.",
      "First see which cup hides the ball; then follow the shuffle; then touch the correct cup.",
      "Keep your eye on the cup that hides the ball while the cups shuffle, and touch it "
      "afterwards.",
      "A cup hides the ball. Track the cups as they change places, and touch the correct one.",
      "See which cup the ball is under, track the cups in the shuffle, then touch that cup.",
      "After you have seen which cup hides the ball, track the shuffle and touch the correct cup.",
      "Touch the cup that hides the ball, after you have tracked it through the shuffle."}},
    {"Observe which color is under each cup, track the cups as they shuffle, then touch the cup "
     "matching the lamp color.",
     {"Look which color is under each cup, follow the cups while they are shuffled, and then touch "
      "the cup that matches the lamp's color.",
      "Remember the color under every cup. Track the cups through the shuffle, then touch the one "
      "with the color of the lamp.",
      "Watch which color each cup has under it, keep track of the cups as they move, and touch the "
      "one that fits the lamp's color.",
      "Note the colors under the cups, follow the shuffle, then touch the cup whose color the lamp "
      "has.",
      "First see which color is under each cup; then follow the shuffle; then touch the cup with "
      "the lamp's color.",
      "Keep the color under each cup in mind while the cups shuffle, and touch the cup matching "
      "the color of the lamp.",
      "There is a color under each cup. Track the cups as they change places, and touch the one "
      "that matches the lamp color.",
      "See which color is under which cup, track the cups in the shuffle, then touch the cup of "
      "the lamp's color.",
      "After you have seen the color under each cup, track the shuffle and touch the cup that the "
      "lamp's color belongs to.",
      "Touch the cup matching the lamp color, after you have tracked through the shuffle which "
      "color is under each cup."}},
};

}  // namespace

std::span<const ParaphraseSet> recall_paraphrases() { return kRecallSets; }

}  // namespace engram
