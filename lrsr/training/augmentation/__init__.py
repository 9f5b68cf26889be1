"""What differs between a rendering and a photograph, and how much of it shall not matter?"""
