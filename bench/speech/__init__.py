"""Commands spoken by synthetic voices, spoiled with noise, heard by Whisper: is the same thing understood?"""
